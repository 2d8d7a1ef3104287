"""From a specification to the gait problem it describes."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

from amble.control.laws import law_for
from amble.control.outputs import joint_outputs
from amble.control.phase import PHASES
from amble.errors import InputError, UnknownNameError, listed, shown
from amble.gait import Limits
from amble.gait.clearances import Clearances, Motor
from amble.gait.cost import COSTS
from amble.gait.limits import Interval
from amble.gait.style import Style  # noqa: F401  (registers it)
from amble.hybrid import CONTACTS, GROUNDS, Contact, Footfall, GaitPattern, Ground, gait_pattern, stance_table
from amble.hybrid.gaits import GAITS
from amble.io.quantities import require_dimension
from amble.robot import Adaptation, Payload, Robot, catalogue, load_robot
from amble.robot.adaptation import BASE
from amble.robot.catalogue import Posture
from amble.robot.proposal import nominal_posture
from amble.robot.sole import lowered
from amble.synthesis.default_limits import default_limits
from amble.synthesis.problem import GaitProblem, intervals_of, on_symmetric
from amble.types import frozen

if TYPE_CHECKING:
    from amble.synthesis.specification import (
        ClearancesSection,
        GaitSection,
        GroundSection,
        LimitsSection,
        PostureSection,
        RobotSection,
        Specification,
    )

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
    robot = robot_of(specification.robot, Path(folder))
    contact = CONTACTS.build(specification.contact.name, specification.contact.parameters)
    ground = _ground(specification.ground)
    pattern = on_symmetric(
        robot, lambda walker: _pattern(specification.gait, walker, ground, contact), specification.robot.symmetrize
    )
    posture = _posture(specification.posture, pattern.robot)
    outputs, margins, asked = specification.outputs, specification.limits.node_margins, specification.gait
    phase, solver = PHASES.build(outputs.phase.name, outputs.phase.parameters), specification.solver
    return GaitProblem(
        pattern=pattern,
        outputs=joint_outputs(pattern, outputs.order, outputs.free, phase, posture),
        outputs_by_default=not outputs.free,
        law=law_for(pattern, specification.law.name, specification.law.parameters),
        speed=specification.gait.speed,
        limits=_limits(specification.limits, default_limits(pattern, posture, asked.yaw_rate), pattern.robot),
        lateral_speed=asked.lateral_speed,
        yaw_rate=asked.yaw_rate,
        posture=posture,
        intervals=intervals_of(solver.scheme, solver.intervals),
        scheme=solver.scheme,
        node_margins=not catalogue.holds(pattern.robot) if margins is None else margins,
        gains=(outputs.position_gain, outputs.velocity_gain),
        cost=COSTS.build(specification.cost.name, specification.cost.parameters),
    )


OF_FILES = {"format", "feet", "gravity", "twins", "symmetrize", "symmetry_tolerance", "foot_radius"}
"""Keys of [robot] that the catalogue has its own answer to."""


def robot_of(section: RobotSection, folder: Path) -> Robot:
    """Load the robot of a section, left and right as they are; errors as in ``problem_of``."""
    if (section.name is None) == (section.file is None):
        raise InputError("[robot] needs either the name of a robot of the catalogue or a file")
    if section.name is not None:
        given = sorted(section.model_fields_set & OF_FILES)
        if given:
            raise InputError(f"[robot] of the catalogue takes no {', '.join(given)}")
        return catalogue.load(section.name, _adaptation(section))
    if not section.feet:
        raise InputError("[robot] with a file needs feet: labels and the links or joints they stand for")
    twins = None if section.twins is None else [(left, right) for left, right in section.twins]
    robot = load_robot(
        folder / _at_home(str(section.file)),
        section.feet,
        section.gravity,
        twins=twins,
        symmetry_tolerance=section.symmetry_tolerance,
        format=section.format,
        adaptation=_adaptation(section),
    )
    return lowered(robot, section.foot_radius) if section.foot_radius else robot


def _at_home(path: str) -> Path:
    """Return a path whose ~ at the beginning is the user's folder, as in a shell."""
    try:
        return Path(path).expanduser()
    except RuntimeError:
        raise InputError(f"the path '{shown(path)}' begins with the home folder of nobody known here") from None


def _adaptation(section: RobotSection) -> Adaptation:
    payload = section.payload

    def by_joint(common: float | None, named: Mapping[str, float]) -> Mapping[str, float]:
        return named if common is None else {"*": common, **named}

    x, y, z = section.base_rotation
    return Adaptation(
        locked=section.locked,
        base=section.base,
        base_rotation=(x, y, z),
        foot_offsets={label: frozen(offset) for label, offset in section.foot_offsets.items()},
        payload=None
        if payload is None
        else Payload(mass=payload.mass, position=frozen(payload.position), link=payload.link or BASE),
        rotor_inertia=by_joint(section.rotor_inertia, section.rotor_inertias),
        damping=by_joint(section.damping, section.dampings),
        dry_friction=by_joint(section.dry_friction, section.dry_frictions),
        friction_width=section.friction_width,
        file_drives=section.file_drives,
        planar=section.planar,
    )


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
    if [section.name, section.stances, section.footfalls].count(None) != 2:
        raise InputError("[gait] needs one of name, stances (a table) and footfalls (duty factors)")
    table: Sequence[Sequence[str]] | None = section.stances
    if section.footfalls is not None:
        table = stance_table({foot: Footfall(fall.phase, fall.duty) for foot, fall in section.footfalls.items()})
    if table is not None:
        return gait_pattern(
            robot, table, section.mirrored, ground=ground, contact=contact, landing_rule=section.landing_rule
        )
    if "mirrored" in section.model_fields_set:
        raise InputError("[gait] with a name takes no 'mirrored'; the gait knows that itself")
    named = GAITS[str(section.name)](robot, ground, contact)
    if "landing_rule" in section.model_fields_set:
        named = replace(named, landing_rule=section.landing_rule)
    return replace(named, mirrored=False) if section.lateral_speed or section.yaw_rate else named


def _limits(section: LimitsSection, default: Limits, robot: Robot) -> Limits:
    """Return the default limits with what the file gives in their place."""
    common = default.durations if section.duration is None else dict.fromkeys(default.durations, section.duration)
    durations = _merged("domain", default.durations, common, section.durations)
    base = {name: _interval(pair) for name, pair in section.base if pair is not None}
    _require_dimensions(section, robot)
    joints = {name: _interval(pair) for name, pair in section.joints.items()}
    names, landing = robot.joint_names, section.touchdown_velocity
    turning = tuple(joint.name for joint in robot.joints if not joint.prismatic)
    return Limits(
        durations={name: _interval(pair) for name, pair in durations.items()},
        positions={**default.positions, **base, **_merged("joint", names, {}, joints)},
        speeds=_merged("joint", names, _common(turning, section.speed, default.speeds), section.speeds),
        torques=_merged("joint", names, _common(turning, section.torque, default.torques), section.torques),
        acceleration=_given(section.acceleration, default.acceleration),
        touchdown_velocity=default.touchdown_velocity
        if landing is None
        else (_interval(landing.x), _interval(landing.y), _interval(landing.z)),
        normal_force=_given(section.normal_force, default.normal_force),
        clearance=_given(section.clearance, default.clearance),
        standing_force=_standing(section, default),
        clearances=_clearances(section.clearances),
        motors=_motors(section, names, turning),
    )


def _clearances(section: ClearancesSection | None) -> Clearances | None:
    if section is None:
        return None
    box = None if section.box is None else (section.box[0], section.box[1], section.box[2])
    return Clearances(knees=section.knees, corners=section.corners, box=box, legs=section.legs)


def _require_dimensions(section: LimitsSection, robot: Robot) -> None:
    """Refuse numbers of joints that turn with units of joints that slide, and the reverse."""
    motors = dict(section.motors) if section.motor is None else {"": section.motor, **section.motors}
    asked: list[tuple[str, Mapping[str, Any], tuple[str, str]]] = [
        ("range", section.joints, ("angle", "length")),
        ("speed", section.speeds, ("angular speed", "speed")),
        ("torque limit", section.torques, ("torque", "force")),
        ("stall_torque", {name: motor.stall_torque for name, motor in motors.items()}, ("torque", "force")),
        ("no_load_speed", {name: motor.no_load_speed for name, motor in motors.items()}, ("angular speed", "speed")),
    ]
    sliding = [joint.name for joint in robot.joints if joint.prismatic]
    for what, values, dimensions in asked:
        for name, value in values.items():
            said = f"{what} of '{name}'" if name else f"{what} of the motor"
            for number in value if isinstance(value, list) else [value]:
                require_dimension(number, dimensions[name in sliding], said)


def _motors(section: LimitsSection, names: Sequence[str], turning: Sequence[str]) -> dict[str, Motor]:
    common = {} if section.motor is None else dict.fromkeys(turning, section.motor)
    given = _merged("joint", names, common, section.motors)
    return {
        name: Motor(stall_torque=each.stall_torque, no_load_speed=each.no_load_speed) for name, each in given.items()
    }


def _posture(section: PostureSection | None, robot: Robot) -> Posture:
    if section is None:
        return nominal_posture(robot)
    angles = _merged("joint", robot.joint_names, {}, section.angles)
    missing = [name for name in robot.joint_names if name not in angles]
    if missing:
        raise InputError(f"[posture] lacks the angle of {listed(missing)}")
    for name, angle in angles.items():
        require_dimension(angle, "length" if robot.joint(name).prismatic else "angle", f"posture of '{name}'")
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


def _common(names: Iterable[str], given: float | None, default: Mapping[str, float]) -> Mapping[str, float]:
    """The default of each joint that has one; where a number is given, it holds for some joints."""
    return default if given is None else {**default, **dict.fromkeys(names, given)}


def _standing(section: LimitsSection, default: Limits) -> float | None:
    """What is given; by default that of the robot, or the normal force where a larger one is given."""
    if section.standing_force is not None or default.standing_force is None:
        return section.standing_force
    return max(default.standing_force, _given(section.normal_force, default.normal_force))


def _given(value: float | None, default: float) -> float:
    return default if value is None else value


def _interval(pair: Iterable[float]) -> Interval:
    lower, upper = pair
    return (lower, upper)
