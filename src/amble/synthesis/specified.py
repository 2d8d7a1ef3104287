"""From a specification to the gait problem it describes."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from amble.control.laws import law_for
from amble.control.outputs import joint_outputs
from amble.control.phase import PHASES
from amble.errors import InputError, UnknownNameError
from amble.gait import Limits
from amble.gait.limits import Interval
from amble.hybrid import CONTACTS, GROUNDS, Contact, GaitPattern, Ground, gait_pattern
from amble.hybrid.gaits import GAITS
from amble.robot import Robot, catalogue, load_robot
from amble.robot.catalogue import GaitBounds, Posture
from amble.synthesis.problem import GaitProblem

if TYPE_CHECKING:
    from amble.synthesis.specification import GaitSection, GroundSection, LimitsSection, RobotSection, Specification

Value = TypeVar("Value")


def problem_of(specification: Specification, folder: str | Path = ".") -> GaitProblem:
    """Build the gait problem of a specification.

    Args:
        specification: what ``read_specification`` returned.
        folder: where a relative path of a robot file starts.

    Raises:
        UnknownNameError: a robot, gait, foot, joint, domain, phase or law that does not exist.
        InputError: something is missing for a robot outside the catalogue, or does not fit together.
    """
    robot = _robot(specification.robot, Path(folder))
    known = catalogue.entry(specification.robot.name) if specification.robot.name else None
    contact = CONTACTS.build(specification.contact.name, specification.contact.parameters)
    pattern = _pattern(specification.gait, robot, _ground(specification.ground), contact)
    outputs = specification.outputs
    phase = PHASES.build(outputs.phase.name, outputs.phase.parameters)
    return GaitProblem(
        pattern=pattern,
        outputs=joint_outputs(pattern, outputs.order, outputs.free, phase),
        law=law_for(pattern, specification.law.name, specification.law.parameters),
        speed=specification.gait.speed,
        limits=_limits(specification.limits, pattern, known.bounds if known else None),
        posture=_posture(specification, robot, known.posture if known else None),
        intervals=specification.solver.intervals,
        gains=(outputs.position_gain, outputs.velocity_gain),
    )


def _robot(section: RobotSection, folder: Path) -> Robot:
    if (section.name is None) == (section.file is None):
        raise InputError("[robot] needs either the name of a robot of the catalogue or a file")
    if section.name is not None:
        given = sorted(section.model_fields_set - {"name"})
        if given:
            raise InputError(f"[robot] of the catalogue takes no {', '.join(given)}")
        return catalogue.load(section.name)
    if not section.feet:
        raise InputError("[robot] with a file needs feet: labels and the links or joints they stand for")
    twins = None if section.twins is None else [(left, right) for left, right in section.twins]
    return load_robot(folder / str(section.file), section.feet, section.gravity, twins=twins)


def _ground(section: GroundSection) -> Ground:
    given = section.model_fields_set
    parameters: dict[str, Any] = {"friction": section.friction}
    if section.name == "plane":
        if "parameters" in given:
            raise InputError("[ground] of a plane takes slope and heading, no parameters")
        parameters |= {"slope": section.slope, "heading": section.heading}
    elif given & {"slope", "heading"}:
        raise InputError(f"[ground] of the name '{section.name}' takes no slope or heading; they belong to a plane")
    return GROUNDS.build(section.name, {**parameters, **section.parameters})


def _pattern(section: GaitSection, robot: Robot, ground: Ground, contact: Contact) -> GaitPattern:
    if (section.name is None) == (section.stances is None):
        raise InputError("[gait] needs either the name of a gait or a table of stances")
    if section.stances is not None:
        return gait_pattern(
            robot, section.stances, section.mirrored, ground=ground, contact=contact, landing_rule=section.landing_rule
        )
    if "mirrored" in section.model_fields_set:
        raise InputError("[gait] with a name takes no 'mirrored'; the gait knows that itself")
    if section.name not in GAITS:
        raise UnknownNameError("gait", str(section.name), GAITS)
    return replace(GAITS[section.name](robot, ground, contact), landing_rule=section.landing_rule)


def _limits(section: LimitsSection, pattern: GaitPattern, bounds: GaitBounds | None) -> Limits:
    robot = pattern.robot
    own_torques = {joint.name: bounds.torque if bounds else joint.effort for joint in robot.joints}
    own_speeds = {joint.name: bounds.speed if bounds else joint.velocity for joint in robot.joints}
    return Limits(
        durations=_durations(section, [stance.name for stance in pattern.solved], bounds),
        positions=_positions(section, robot, bounds),
        speeds=_merged("joint", robot.joint_names, _common(section.speed, own_speeds), section.speeds),
        torques=_merged("joint", robot.joint_names, _common(section.torque, own_torques), section.torques),
        acceleration=_first(
            "limits.acceleration", section.acceleration, None if bounds is None else bounds.acceleration
        ),
        touchdown_velocity=_touchdown(section, bounds),
        normal_force=section.normal_force,
        clearance=section.clearance,
    )


def _durations(section: LimitsSection, stances: list[str], bounds: GaitBounds | None) -> dict[str, Interval]:
    named = _merged("domain", stances, {}, {name: _interval(pair) for name, pair in section.durations.items()})
    if set(named) == set(stances):
        return named
    given = None if section.duration is None else _interval(section.duration)
    common = _first("limits.duration", given, None if bounds is None else bounds.duration)
    return {name: named.get(name, common) for name in stances}


def _touchdown(section: LimitsSection, bounds: GaitBounds | None) -> tuple[Interval, Interval, Interval]:
    landing = section.touchdown_velocity
    given = None if landing is None else (_interval(landing.x), _interval(landing.y), _interval(landing.z))
    return _first("limits.touchdown_velocity", given, None if bounds is None else bounds.touchdown_velocity)


def _positions(section: LimitsSection, robot: Robot, bounds: GaitBounds | None) -> dict[str, Interval]:
    base = {name: _interval(pair) for name, pair in section.base if pair is not None}
    joints = {name: _interval(pair) for name, pair in section.joints.items()}
    if bounds is not None:
        common = dict(bounds.positions)
    else:
        common = {joint.name: (joint.lower, joint.upper) for joint in robot.joints}
    return {**common, **base, **_merged("joint", robot.joint_names, {}, joints)}


def _posture(specification: Specification, robot: Robot, known: Posture | None) -> Posture:
    section = specification.posture
    if section is None:
        return _first("posture", None, known)
    angles = _merged("joint", robot.joint_names, {}, section.angles)
    missing = [name for name in robot.joint_names if name not in angles]
    if missing:
        raise InputError(f"[posture] lacks the angle of {', '.join(missing)}")
    return Posture(section.height, angles)


def _merged(
    kind: str, known: Iterable[str], common: Mapping[str, Value], named: Mapping[str, Value]
) -> dict[str, Value]:
    """Let what is named on its own take the place of what holds for all."""
    names = tuple(known)
    for name in named:
        if name not in names:
            raise UnknownNameError(kind, name, names)
    return {**common, **named}


def _common(given: float | None, own: Mapping[str, float]) -> dict[str, float]:
    """One number for all joints where it is given, else each joint's own where it has one."""
    if given is not None:
        return dict.fromkeys(own, given)
    return {name: value for name, value in own.items() if math.isfinite(value)}


def _first(key: str, given: Value | None, known: Value | None) -> Value:
    """Return what the file gives, else what the catalogue knows."""
    if given is not None:
        return given
    if known is not None:
        return known
    raise InputError(f"'{key}' is needed for a robot that is not in the catalogue")


def _interval(pair: Iterable[float]) -> Interval:
    lower, upper = pair
    return (lower, upper)
