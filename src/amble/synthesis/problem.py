"""The gait problem: what is to be walked, by which law, within which limits; and what fits a robot by default."""

from __future__ import annotations

import logging
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace

from amble.amounts import check_amount
from amble.control import AllocationLaw, Outputs, PseudoInverse, joint_outputs
from amble.errors import InputError, UnknownNameError, printable
from amble.gait import Limits
from amble.gait.clearances import check_clearances
from amble.gait.command import Command
from amble.gait.cost import TORQUE_SQUARED, Cost
from amble.gait.limits import SLOWEST_LANDING, highest_landing
from amble.hybrid import FLAT, POINT, GaitPattern, Ground
from amble.hybrid.gaits import GAITS
from amble.numerics.collocation import HERMITE_SIMPSON, CollocationScheme, collocation_scheme
from amble.robot import Robot, catalogue, symmetrized
from amble.robot.catalogue import Posture
from amble.robot.mirror import AsymmetryError
from amble.robot.proposal import nominal_posture
from amble.synthesis.default_limits import default_limits

logger = logging.getLogger("amble")

MOST_INTERVALS = 10_000
"""Of a domain."""

RELEASE = 0.001
"""Least speed of a released foot away from the ground, as a share of sqrt(g l): from a start beside the orbit a slower
one would touch the ground at once."""

INTERVALS = {HERMITE_SIMPSON: 15, "lobatto-5": 6, "lobatto-7": 5}
"""Scheme -> intervals of a domain by default: the objective of ASTRo's amble is as accurate on each (docs/decisions.md,
"Higher-order meshes")."""

LARGEST_AVERAGED = 0.05
"""Largest relative asymmetry that is averaged unasked; real files have 1e-4 to 0.2."""


@dataclass(frozen=True, kw_only=True)
class GaitProblem:
    """Find the periodic motion of the smallest mean cost, by default of the squared torques (paper, eq. 6).

    Attributes:
        pattern: the cyclic table of stances.
        outputs: controlled coordinates and Bezier order.
        law: the allocation law, obeyed at every node.
        speed: required mean velocity along the world's x axis, m/s, negative backwards; on a slope the robot
            also climbs.
        lateral_speed: required mean velocity to the left, m/s; along y where the heading stays.
        yaw_rate: required mean rate of the heading about the vertical, rad/s. The velocities turn with it.
        limits: bounds of the motion and the contacts.
        posture: where the solver starts: base height and joint angles.
        intervals: collocation intervals in every domain.
        scheme: name of the collocation scheme (``numerics.collocation.STAGES``).
        node_margins: whether positions, accelerations and normal forces keep a margin of their bounds free at the
            nodes, so that they keep to them between the nodes; speeds, torques and friction always do (``layout``).
        gains: (K_p in 1/s^2, K_d in 1/s) of the output dynamics.
        cost: what is minimised.
        outputs_by_default: whether nobody said which coordinates are controlled, so that ``synthesize`` may choose
            others where these can hardly be decoupled along the motion.
        release: least speed away from the ground of a foot that a landing releases, as a share of sqrt(g l).
    """

    pattern: GaitPattern
    outputs: Outputs
    law: AllocationLaw
    speed: float
    limits: Limits
    posture: Posture
    intervals: int = 15
    scheme: str = HERMITE_SIMPSON
    node_margins: bool = False
    gains: tuple[float, float] = (100.0, 20.0)
    cost: Cost = TORQUE_SQUARED
    lateral_speed: float = 0.0
    yaw_rate: float = 0.0
    outputs_by_default: bool = False
    release: float = RELEASE

    @property
    def command(self) -> Command:
        """The velocities that are asked for."""
        return Command(forward=self.speed, lateral=self.lateral_speed, yaw_rate=self.yaw_rate)

    @property
    def nodes(self) -> int:
        """Number of nodes of every domain."""
        return self.intervals * (self.collocation.stages - 1) + 1

    @property
    def collocation(self) -> CollocationScheme:
        """The scheme itself."""
        return collocation_scheme(self.scheme)

    def __post_init__(self) -> None:
        """Check numbers and names."""
        _possible(self.command, self.pattern)
        check_amount("intervals a domain", self.intervals, 2, MOST_INTERVALS)
        if not 0.0 < self.release <= 1.0:
            raise InputError(f"the least speed of a released foot is {self.release:g} sqrt(g l); it must be in (0, 1]")
        collocation_scheme(self.scheme)
        if not all(gain > 0.0 for gain in self.gains):
            raise InputError(f"the output gains are {self.gains}; both must be positive")
        if "x" not in self.pattern.ground.translations:
            name = self.pattern.ground.name
            raise InputError(f"a periodic gait needs ground that stays the same along x; ground '{name}' does not")
        robot, limits = self.pattern.robot, self.limits
        _known("domain", limits.durations, [stance.name for stance in self.pattern.solved])
        for stance in self.pattern.solved:
            if stance.name not in limits.durations:
                raise InputError(f"the limits have no bounds for the duration of domain '{stance.name}'")
        _known("joint", (*limits.speeds, *limits.torques), robot.joint_names)
        _known("coordinate", limits.positions, robot.coordinate_names)
        _known("joint with a motor", limits.motors, robot.joint_names)
        check_clearances(robot, limits.clearances)
        _comes_down(limits, robot)
        leaving = [foot for switch in self.pattern.switches for foot in switch.leaving]
        if leaving and not limits.normal_force > 0.0:
            raise InputError(
                f"foot '{leaving[0]}' leaves the ground by its force, so the smallest normal force must be above 0: "
                "at 0 no friction is left to hold it"
            )


def _possible(command: Command, pattern: GaitPattern) -> None:
    """Refuse commands that the pattern or its ground cannot have."""
    if not (command.ahead or pattern.robot.base.in_space):
        raise InputError(f"robot '{pattern.robot.name}' moves in a plane: it has no lateral speed and no yaw rate")
    if pattern.mirrored and not command.ahead:
        raise InputError(
            f"gait '{pattern.name}' is mirrored, so it goes straight ahead: a lateral speed or a yaw rate needs a "
            "pattern without the mirror (mirrored = false)"
        )
    if not command.straight and not pattern.ground.level:
        raise InputError("a gait with a yaw rate needs level ground: on other ground a turn changes the motion")
    if command.lateral != 0.0 and "y" not in pattern.ground.translations:
        raise InputError("a gait with a lateral speed needs ground that stays the same along y")


def _comes_down(limits: Limits, robot: Robot) -> None:
    """Refuse limits under which a landing foot may graze the ground; a hair is left for numbers written in decimals."""
    upper, most = limits.touchdown_velocity[2][1], highest_landing(robot)
    if upper > (1.0 - 1e-9) * most:
        raise InputError(
            f"the touchdown velocity along z may be as high as {upper:g} m/s, but a foot that grazes the ground has no "
            f"moment of touchdown: the upper bound is at most {most:.6g} m/s ({SLOWEST_LANDING:g} sqrt(g l) downwards)"
        )


def _known(kind: str, names: Iterable[str], known: Sequence[str]) -> None:
    for name in names:
        if name not in known:
            raise UnknownNameError(kind, name, known)


def on_symmetric(
    robot: Robot, build: Callable[[Robot], GaitPattern], symmetrize: bool | float | None = None
) -> GaitPattern:
    """Build the pattern of a robot; where its mirror needs that, of the robot with left and right averaged.

    Args:
        robot: the robot.
        build: the pattern of a robot.
        symmetrize: whether left and right are averaged; a number averages them only where the gait is mirrored and the
            robot deviates by more than its tolerance and at most so much, with a notice. By default the number is
            ``LARGEST_AVERAGED``.

    Raises:
        AsymmetryError: the robot is not as symmetric as the gait.
        InputError: what ``build`` raises.
    """
    if symmetrize is True:
        return build(symmetrized(robot))
    most = LARGEST_AVERAGED if symmetrize is None else float(symmetrize)
    try:
        return build(robot)
    except AsymmetryError as error:
        if error.asymmetry > most:
            raise
        logger.warning(
            "%s: %s differs by %.2g of its size from left to right; left and right are averaged",
            printable(robot.name),
            error.what,
            error.asymmetry,
        )
        return build(symmetrized(robot))


def gait_problem(
    robot: Robot,
    gait: str | GaitPattern,
    *,
    speed: float,
    ground: Ground | None = None,
    outputs: Outputs | None = None,
    law: AllocationLaw | None = None,
    limits: Limits | None = None,
    posture: Posture | None = None,
    intervals: int | None = None,
    scheme: str = HERMITE_SIMPSON,
    cost: Cost = TORQUE_SQUARED,
    lateral_speed: float = 0.0,
    yaw_rate: float = 0.0,
) -> GaitProblem:
    """Pose the gait problem of a robot.

    Args:
        robot: the robot.
        gait: the name of a gait (amble, trot, or one that was registered) or a pattern of stances of the robot.
        speed: mean forward velocity, m/s.
        ground: what a gait given by name walks on; level, with a friction of 0.6, by default. A pattern has its own.
        outputs: the controlled coordinates; by default those of ``joint_outputs``.
        law: the allocation law; by default the pseudo-inverse.
        limits: the bounds; by default those of ``default_limits``.
        posture: where the solver starts; by default that of the catalogue, else ``standing_posture``.
        intervals: collocation intervals in every domain; by default those of the scheme (``INTERVALS``).
        scheme: the collocation scheme: hermite-simpson, lobatto-5 or lobatto-7, of three, five or seven nodes.
        cost: what is minimised; by default the squared torques.
        lateral_speed: mean velocity to the left, m/s.
        yaw_rate: mean rate of the heading, rad/s. With one of both a gait given by name is taken without its mirror.

    Raises:
        UnknownNameError: there is no gait of that name, or it names feet that the robot does not have.
        InputError: the pattern is of another robot, the robot is less symmetric than a gait given by name can mend
            (see ``amble.symmetrized``; up to 5 % are averaged with a notice), or no posture is known by default.
    """
    pattern = _pattern(robot, gait, ground)
    if not isinstance(gait, GaitPattern) and (lateral_speed or yaw_rate):
        pattern = replace(pattern, mirrored=False)
    stands = posture or nominal_posture(pattern.robot)
    return GaitProblem(
        pattern=pattern,
        outputs=joint_outputs(pattern, posture=stands) if outputs is None else outputs,
        law=law or PseudoInverse(),
        speed=speed,
        limits=default_limits(pattern, stands, yaw_rate) if limits is None else limits,
        posture=stands,
        intervals=intervals_of(scheme, intervals),
        scheme=scheme,
        cost=cost,
        lateral_speed=lateral_speed,
        yaw_rate=yaw_rate,
        node_margins=not catalogue.holds(pattern.robot),
        outputs_by_default=outputs is None,
    )


def intervals_of(scheme: str, intervals: int | None) -> int:
    """Return the number of intervals that is asked for, or that of the scheme.

    Raises:
        UnknownNameError: there is no scheme of that name.
    """
    return INTERVALS[collocation_scheme(scheme).name] if intervals is None else intervals


def _pattern(robot: Robot, gait: str | GaitPattern, ground: Ground | None) -> GaitPattern:
    if isinstance(gait, GaitPattern):
        if ground is not None and ground != gait.ground:
            raise InputError(f"the gait pattern '{gait.name}' has a ground of its own; give it another one there")
        if gait.robot != robot:
            raise InputError(f"the gait pattern '{gait.name}' is of robot '{gait.robot.name}', not of this one")
        return gait
    return on_symmetric(robot, lambda walker: GAITS[gait](walker, ground or FLAT, POINT))
