"""The specification of a gait problem as a TOML file, validated on reading.

Every key, joint, foot, domain and unit that does not exist is an error that names those that do. A quantity is a plain
SI number or text with a unit (see ``quantities``). What the file does not say comes from the catalogue for a robot of
the catalogue (its builders' bounds and posture); for another robot joint limits come from its URDF, and the rest
follows from its size and weight, as in ``gait_problem``.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, Field, ValidationError

from amble.errors import InputError, shown
from amble.gait.constraints import REFERENCE_ORDER
from amble.hybrid import ONE_BY_ONE
from amble.io.reader import read_toml
from amble.numerics.collocation import HERMITE_SIMPSON
from amble.synthesis.quantity_types import (
    Acceleration,
    Angle,
    AngleRange,
    Angles,
    AngularSpeed,
    Damping,
    Force,
    Inertia,
    JointDamping,
    JointInertia,
    JointLoad,
    JointRange,
    JointSpeed,
    JointValue,
    Length,
    LengthRange,
    Mass,
    Pair,
    Point,
    PositionGain,
    Ratio,
    Speed,
    SpeedRange,
    TimeRange,
    Torque,
    VelocityGain,
    parser,
)
from amble.synthesis.specification_faults import in_one_sentence, lacking


class Section(BaseModel):
    """A table of the file: nothing unknown, nothing converted."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True)


class PayloadSection(Section):
    """A point mass that a link of the file carries, at a position in that link's frame; by default the base."""

    mass: Mass
    position: Point = [0.0, 0.0, 0.0]
    link: str | None = None


class RobotSection(Section):
    """A robot of the catalogue by ``name``, or a ``file`` (relative to the specification) with its ``feet``.

    The suffix of a file's name tells its format where ``format`` does not. ``symmetrize`` averages left and right; a
    number does so for a mirrored gait, up to that asymmetry and with a notice. The keys after it adapt the robot of the
    file (``amble.Adaptation``); one rotor inertia, damping or dry friction holds for all joints that turn and are not
    named.
    """

    name: str | None = None
    file: str | None = None
    format: str | None = None
    feet: dict[str, str] | None = None
    gravity: Acceleration = 9.81
    twins: list[Pair] | None = None
    symmetrize: bool | Annotated[float, BeforeValidator(parser("ratio")), Field(ge=0.0)] | None = None
    symmetry_tolerance: Ratio = Field(default=1e-9, ge=0.0)
    locked: dict[str, JointValue] = {}
    base: str | None = None
    base_rotation: Angles = [0.0, 0.0, 0.0]
    foot_offsets: dict[str, Point] = {}
    foot_radius: Length = 0.0
    payload: PayloadSection | None = None
    file_drives: bool = True
    rotor_inertia: Inertia | None = None
    rotor_inertias: dict[str, JointInertia] = {}
    damping: Damping | None = None
    dampings: dict[str, JointDamping] = {}
    dry_friction: Torque | None = None
    dry_frictions: dict[str, JointLoad] = {}
    friction_width: AngularSpeed | None = None
    planar: bool = False


class FootfallSection(Section):
    """The phase at which a foot lands and its duty factor, both as shares of the cycle."""

    phase: Ratio
    duty: Ratio


class GaitSection(Section):
    """A known gait by ``name``, or a table of ``stances``, or ``footfalls``; mean velocities; how several feet land.

    Every foot of ``footfalls`` has the phase at which it lands and its duty factor; ``mirrored`` belongs to a table or
    to footfalls.
    """

    speed: Speed
    name: str | None = None
    stances: list[list[str]] | None = None
    footfalls: dict[str, FootfallSection] | None = None
    mirrored: bool = False
    landing_rule: str = ONE_BY_ONE
    lateral_speed: Speed = 0.0
    yaw_rate: AngularSpeed = 0.0


class PhaseSection(Section):
    """The variable that the curves run on, by name, with its parameters."""

    name: str = "time"
    parameters: dict[str, Any] = {}


class OutputsSection(Section):
    """Order and phase of the Bezier curves, the joints that are not controlled (domain -> joints), the output gains."""

    order: int = Field(default=4, ge=3, le=REFERENCE_ORDER)
    phase: PhaseSection = PhaseSection()
    free: dict[str, list[str]] = {}
    position_gain: PositionGain = 100.0
    velocity_gain: VelocityGain = 20.0


class LawSection(Section):
    """Allocation law by name, with its parameters."""

    name: str = "pinv"
    parameters: dict[str, Any] = {}


class CostSection(Section):
    """What is minimised, by the name of a registered cost, with its parameters."""

    name: str = "torque squared"
    parameters: dict[str, Any] = {}


class TouchdownSection(Section):
    """Velocity of a landing foot just before the impact: along the ground's tangents and its normal."""

    x: SpeedRange
    y: SpeedRange
    z: SpeedRange


class BaseSection(Section):
    """Ranges of the base coordinates; z above the ground under the base."""

    z: LengthRange | None = None
    roll: AngleRange | None = None
    pitch: AngleRange | None = None
    yaw: AngleRange | None = None


class ClearancesSection(Section):
    """Least distances of knees and base corners from the ground and of left from right legs; the base's box."""

    knees: Length | None = None
    corners: Length | None = None
    box: Point | None = None
    legs: Length | None = None


class MotorSection(Section):
    """A motor's line of torque over speed, at the joint; of force over speed where it slides."""

    stall_torque: JointLoad
    no_load_speed: JointSpeed


class LimitsSection(Section):
    """Bounds; ``duration`` holds for all domains not named themselves.

    ``torque``, ``speed`` and ``motor`` hold for all joints that turn and are not named themselves.
    """

    clearance: Length | None = None
    normal_force: Force | None = None
    standing_force: Force | None = None
    node_margins: bool | None = None
    duration: TimeRange | None = None
    durations: dict[str, TimeRange] = {}
    torque: Torque | None = None
    torques: dict[str, JointLoad] = {}
    speed: AngularSpeed | None = None
    speeds: dict[str, JointSpeed] = {}
    acceleration: Acceleration | None = None
    base: BaseSection = BaseSection()
    joints: dict[str, JointRange] = {}
    touchdown_velocity: TouchdownSection | None = None
    clearances: ClearancesSection | None = None
    motor: MotorSection | None = None
    motors: dict[str, MotorSection] = {}


class GroundSection(Section):
    """Friction and, for a plane, its slope and the direction in which it rises; or a registered ground by ``name``."""

    friction: Ratio = 0.6
    slope: Angle = 0.0
    heading: Angle = 0.0
    name: str = "plane"
    parameters: dict[str, Any] = {}


class ContactSection(Section):
    """What a foot on the ground is, by the name of a registered contact, with its parameters."""

    name: str = "point"
    parameters: dict[str, Any] = {}


class PostureSection(Section):
    """Where the solver starts: base height and joint angles, or displacements."""

    height: Length
    angles: dict[str, JointValue]


class SolverSection(Section):
    """Scheme, intervals a domain, how many a solved one is cut into, tolerance of the scaled problem, iterations.

    ``name`` is that of a registered solver. A scheme (``numerics.collocation.STAGES``) has its number of intervals by
    default. Without ``refinement`` the mesh is made finer where the check of the gait needs that.
    """

    name: str = "ipopt"
    scheme: str = HERMITE_SIMPSON
    intervals: int | None = Field(default=None, ge=2, le=1000)
    refinement: int | None = Field(default=None, ge=1, le=100)
    tolerance: Ratio = Field(default=1e-8, gt=0.0)
    iterations: int = Field(default=500, ge=1, le=1_000_000)


class Specification(Section):
    """A whole file."""

    robot: RobotSection
    gait: GaitSection
    limits: LimitsSection = LimitsSection()
    ground: GroundSection = GroundSection()
    contact: ContactSection = ContactSection()
    outputs: OutputsSection = OutputsSection()
    law: LawSection = LawSection()
    cost: CostSection = CostSection()
    posture: PostureSection | None = None
    solver: SolverSection = SolverSection()


def read_specification(path: str | Path) -> Specification:
    """Read and validate a specification.

    Raises:
        InputError: in one sentence, where the file is missing or not TOML, a key is missing, unknown (known ones are
            named) or of another kind, or a quantity has an unknown unit or is not finite.
    """
    path = Path(path)
    tree = read_toml(path, "specification")
    if "library" in tree:
        raise InputError(f"{shown(path.name)} has a table [library]: its gaits are found by `amble library`")
    return specification_of(tree, path.name)


def specification_of(tree: Mapping[str, Any], name: str) -> Specification:
    """Validate a specification as a tree, called ``name`` in errors; these are as in ``read_specification``."""
    return validated(tree, name, Specification)


Kind = TypeVar("Kind", bound=Specification)


def validated(tree: Mapping[str, Any], name: str, kind: type[Kind]) -> Kind:
    """Validate a specification that may have further tables; errors as in ``specification_of``."""
    missing = lacking(tree)
    if missing:
        raise InputError(f"{shown(name)} lacks {'; '.join(missing)}")
    try:
        return kind.model_validate(tree)
    except ValidationError as error:
        raise in_one_sentence(name, error, kind) from None
