"""Quantities as fields of a specification: a plain SI number, or text with a unit of the field's dimension."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Any

from pydantic import AfterValidator, BeforeValidator, Field, PlainValidator

from amble.io.quantities import Measured, parse_measured, parse_quantity


def parser(dimension: str) -> Callable[[Any], float]:
    """Return what reads a quantity of a dimension."""
    return lambda value: parse_quantity(value, dimension)


def _of_joints(turning: str, sliding: str) -> PlainValidator:
    """Of joints that turn and joints that slide; which of the two a joint does, its robot tells."""
    return PlainValidator(lambda value: parse_measured(value, (turning, sliding)))


def ordered(pair: list[float]) -> list[float]:
    """Refuse a range whose ends are the wrong way round."""
    if pair[0] > pair[1]:
        raise ValueError(f"the lower end {pair[0]:g} lies above the upper end {pair[1]:g}")
    return pair


Length = Annotated[float, BeforeValidator(parser("length"))]
Angle = Annotated[float, BeforeValidator(parser("angle"))]
Time = Annotated[float, BeforeValidator(parser("time"))]
Speed = Annotated[float, BeforeValidator(parser("speed"))]
AngularSpeed = Annotated[float, BeforeValidator(parser("angular speed"))]
Acceleration = Annotated[float, BeforeValidator(parser("acceleration"))]
Force = Annotated[float, BeforeValidator(parser("force"))]
Torque = Annotated[float, BeforeValidator(parser("torque"))]
PositionGain = Annotated[float, BeforeValidator(parser("position gain"))]
VelocityGain = Annotated[float, BeforeValidator(parser("velocity gain"))]
Mass = Annotated[float, BeforeValidator(parser("mass"))]
Inertia = Annotated[float, BeforeValidator(parser("inertia"))]
Damping = Annotated[float, BeforeValidator(parser("damping"))]
JointValue = Annotated[Measured, _of_joints("angle", "length")]
JointSpeed = Annotated[Measured, _of_joints("angular speed", "speed")]
JointLoad = Annotated[Measured, _of_joints("torque", "force")]
JointInertia = Annotated[Measured, _of_joints("inertia", "mass")]
JointDamping = Annotated[Measured, _of_joints("damping", "linear damping")]
Ratio = Annotated[float, BeforeValidator(parser("ratio"))]

TimeRange = Annotated[list[Time], Field(min_length=2, max_length=2), AfterValidator(ordered)]
SpeedRange = Annotated[list[Speed], Field(min_length=2, max_length=2), AfterValidator(ordered)]
LengthRange = Annotated[list[Length], Field(min_length=2, max_length=2), AfterValidator(ordered)]
AngleRange = Annotated[list[Angle], Field(min_length=2, max_length=2), AfterValidator(ordered)]
JointRange = Annotated[list[JointValue], Field(min_length=2, max_length=2), AfterValidator(ordered)]
Point = Annotated[list[Length], Field(min_length=3, max_length=3)]
Angles = Annotated[list[Angle], Field(min_length=3, max_length=3)]
Pair = Annotated[list[str], Field(min_length=2, max_length=2)]
