"""The robot inside a gait file: complete, so that a gait can be checked and walked without the robot's own file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from amble.errors import InputError, UnknownNameError
from amble.io.codec import TEXT, ByName, Codec, Count, ListOf, NameIn, Optional, Record
from amble.io.quantities import Array, Interval, Number
from amble.robot.base import BASES, SPACE
from amble.robot.model import Robot
from amble.robot.parts import DRIVE, Foot, Joint, Link, Payload
from amble.types import Json

PRISMATIC = "prismatic"
"""The kind that files name; joints without a kind are revolute."""


def _joint(range: tuple[float, float], kind: str | None, **fields: Any) -> Joint:
    lower, upper = range
    return Joint(lower=lower, upper=upper, prismatic=kind == PRISMATIC, **fields)


def _kind(joint: Joint) -> str | None:
    return PRISMATIC if joint.prismatic else None


LINK = Record(Link, {"name": TEXT, "mass": Number("kg"), "center": Array("m", 3), "inertia": Array("kg m^2", 3, 3)})


def _of_kind(turning: Codec, sliding: Codec) -> Callable[[Mapping[str, Any]], Codec]:
    """Codec of what has other units for prismatic joints."""
    return lambda known: sliding if known.get("kind") == PRISMATIC else turning


JOINT = Record(
    _joint,
    {
        "name": TEXT,
        "kind": Optional(NameIn("kind of joint", (PRISMATIC,))),
        "parent": Count(),
        "child": Count(),
        "rotation": Array("1", 3, 3),
        "translation": Array("m", 3),
        "axis": Array("1", 3),
        "range": _of_kind(Interval("rad", infinite=True), Interval("m", infinite=True)),
        "effort": _of_kind(Number("N m", infinite=True), Number("N", infinite=True)),
        "velocity": _of_kind(Number("rad/s", infinite=True), Number("m/s", infinite=True)),
    },
    take=lambda joint: {**vars(joint), "range": (joint.lower, joint.upper), "kind": _kind(joint)},
)

DRIVEN = Record(
    dict,
    {
        "kind": Optional(NameIn("kind of joint", (PRISMATIC,))),
        "rotor_inertia": _of_kind(Number("kg m^2"), Number("kg")),
        "damping": _of_kind(Number("N m s/rad"), Number("N s/m")),
        "dry_friction": _of_kind(Number("N m"), Number("N")),
        "friction_width": _of_kind(Number("rad/s"), Number("m/s")),
    },
)
"""What stands between a joint's torque, or force, and its motion."""

PAYLOAD = Record(Payload, {"mass": Number("kg"), "position": Array("m", 3), "link": TEXT})


class _Payload(Codec):
    """A payload, or an empty object where nothing is carried."""

    def encode(self, value: Any, place: str) -> Json:
        """Write the payload."""
        return {} if value is None else PAYLOAD.encode(value, place)

    def decode(self, entry: Any, place: str) -> Payload | None:
        """Read the payload."""
        if entry == {}:
            return None
        payload: Payload = PAYLOAD.decode(entry, place)
        return payload


OVERLAYS = Record(
    dict,
    {"locked_joints": ByName("joint", Number("rad or m")), "rotors": ByName("joint", DRIVEN), "payload": _Payload()},
)
"""What is laid over links and joints; three empty objects where nothing is."""

FOOT = Record(Foot, {"name": TEXT, "frame": TEXT, "link": Count(), "offset": Array("m", 3)})


def _take(robot: Robot) -> Mapping[str, Any]:
    overlays = {
        "locked_joints": robot.locked_joints,
        "rotors": {
            joint.name: {"kind": _kind(joint), **{what: getattr(joint, what) for what in DRIVE}}
            for joint in robot.joints
            if not joint.driven_freely
        },
        "payload": robot.payload,
    }
    base = None if robot.base.in_space else robot.base.name
    return {**vars(robot), "hash": robot.hash, "overlays": overlays, "base": base}


def robot_of(overlays: Json, joints: tuple[Joint, ...], base: str | None, **fields: Any) -> Robot:
    """Build a robot of what a gait file says of it, whatever hash that is written with."""
    names, rotors = [joint.name for joint in joints], overlays["rotors"]
    for name in rotors:
        if name not in names:
            raise UnknownNameError("joint (rotors of the robot of the gait)", name, names)
    return Robot(
        joints=tuple(_driven(joint, rotors[joint.name]) if joint.name in rotors else joint for joint in joints),
        locked_joints=overlays["locked_joints"],
        payload=overlays["payload"],
        base=BASES[base or SPACE.name],
        **fields,
    )


def _driven(joint: Joint, rotor: Json) -> Joint:
    """Lay what a file says of a joint's rotor over the joint, whose kind it has to know."""
    if rotor["kind"] != _kind(joint):
        raise InputError(f"the rotor of joint '{joint.name}' in the gait file is that of another kind of joint")
    return replace(joint, **{what: rotor[what] for what in DRIVE})


def _build(hash: str, **fields: Any) -> Robot:
    """Build a robot, and hold it against the hash it was written with."""
    robot = robot_of(**fields)
    if robot.hash != hash:
        raise InputError(
            f"gait of another robot: what the file says of '{robot.name}' does not have the hash it was written with"
        )
    return robot


ROBOT = Record(
    _build,
    {
        "name": TEXT,
        "source": TEXT,
        "hash": TEXT,
        "gravity": Number("m/s^2"),
        "symmetry_tolerance": Number("1"),
        "twins": ListOf(ListOf(TEXT, 2)),
        "overlays": OVERLAYS,
        "links": ListOf(LINK),
        "joints": ListOf(JOINT),
        "feet": ListOf(FOOT),
        "base": Optional(NameIn("base", BASES)),
    },
    take=_take,
)
"""Everything of a robot; that it is complete follows from its hash."""
