"""The gait problem: what is to be walked, by which law, within which limits."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

from amble.control import AllocationLaw, Outputs
from amble.errors import InputError, UnknownNameError
from amble.gait import Limits
from amble.gait.cost import TORQUE_SQUARED, Cost
from amble.gait.limits import SLOWEST_LANDING, highest_landing
from amble.hybrid import GaitPattern
from amble.robot import Robot
from amble.robot.catalogue import Posture


@dataclass(frozen=True, kw_only=True)
class GaitProblem:
    """Find the periodic motion of the smallest mean cost, by default of the squared torques (paper, eq. 6).

    Attributes:
        pattern: the cyclic table of stances.
        outputs: controlled coordinates and Bezier order.
        law: the allocation law, obeyed at every node.
        speed: required mean velocity along the world's x axis, m/s; on a slope the robot also climbs.
        limits: bounds of the motion and the contacts.
        posture: where the solver starts: base height and joint angles.
        intervals: Hermite-Simpson intervals in every domain.
        node_margins: whether positions and accelerations keep a margin of their bounds free at the nodes, so that they
            keep to them between the nodes; speeds, torques and friction always do (``bounds``).
        gains: (K_p in 1/s^2, K_d in 1/s) of the output dynamics.
        cost: what is minimised.
    """

    pattern: GaitPattern
    outputs: Outputs
    law: AllocationLaw
    speed: float
    limits: Limits
    posture: Posture
    intervals: int = 15
    node_margins: bool = False
    gains: tuple[float, float] = (100.0, 20.0)
    cost: Cost = TORQUE_SQUARED

    def __post_init__(self) -> None:
        """Check numbers and names."""
        if not -100.0 < self.speed < 100.0:
            raise InputError(f"the speed is {self.speed} m/s; it must be a number of reasonable size")
        if self.intervals < 2:
            raise InputError(f"{self.intervals} intervals a domain are too few; at least 2 are needed")
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
        _comes_down(limits, robot)
        leaving = [foot for switch in self.pattern.switches for foot in switch.leaving]
        if leaving and not limits.normal_force > 0.0:
            raise InputError(
                f"foot '{leaving[0]}' leaves the ground by its force, so the smallest normal force must be above 0: "
                "at 0 no friction is left to hold it"
            )


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
