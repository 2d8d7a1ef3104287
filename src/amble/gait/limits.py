"""What a gait must keep to: bounds on durations, states, torques and contacts. Read by synthesis and by the check."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from math import inf

from amble.errors import InputError
from amble.gait.clearances import Clearances, Motor
from amble.residual import Residual
from amble.robot import Robot
from amble.robot.coordinate_units import unit_of
from amble.robot.natural_units import velocity_unit
from amble.types import Vector

LARGEST_FRICTION = 2.0
"""No foot on any floor of practice holds more; rubber on rough concrete has about 1."""

SMALLEST_TORQUE = 0.01
"""Smallest sensible limit of a torque, as a share of weight times leg length."""

GRAVITY = (0.5, 30.0)
"""From a large moon to a giant planet, m/s^2."""

SLOWEST_LANDING = 0.02
"""Least speed of a landing foot towards the ground, as a share of sqrt(g l), that of a fall from 0.02 % of the leg
length: a foot that grazes the ground has no moment of touchdown, and a motion near it misses the ground."""

Interval = tuple[float, float]


@dataclass(frozen=True, kw_only=True)
class Limits:
    """Bounds of a gait problem, SI units and radians; contact quantities in the frame of the ground.

    Attributes:
        durations: domain name -> (shortest, longest) duration, s.
        positions: name of a base coordinate (x, y, z above the ground under the base, roll, pitch, yaw) or joint ->
            (lower, upper), m or rad.
        speeds: joint name -> largest |rate|, rad/s.
        torques: joint name -> largest |torque|, N m.
        acceleration: largest |second derivative| of an angle, rad/s^2; times the leg length that of x, y and z, m/s^2.
        touchdown_velocity: velocity of a landing foot just before the impact along the ground's two tangents and its
            normal (on level ground x, y, z) -> (lower, upper), m/s; a gait problem needs an upper bound along the
            normal of at most ``highest_landing``.
        normal_force: smallest normal force of a stance foot, N; where feet leave by their force, that at which they do.
        clearance: height above the ground that every swing foot exceeds at the middle of its swing, m.
        standing_force: smallest normal force of a stance foot that stays, and at the entry of one that leaves by its
            force, whose bound falls from there to ``normal_force`` linearly in time, N; by default ``normal_force``. A
            foot that hardly carries lifts off too early after a small disturbance.
        clearances: least distances of knees and base from the ground and of legs from each other; none by default.
        motors: joint name -> its largest torque over its speed; none by default.
    """

    durations: Mapping[str, Interval]
    positions: Mapping[str, Interval]
    speeds: Mapping[str, float]
    torques: Mapping[str, float]
    acceleration: float
    touchdown_velocity: tuple[Interval, Interval, Interval]
    normal_force: float
    clearance: float
    standing_force: float | None = None
    clearances: Clearances | None = None
    motors: Mapping[str, Motor] = field(default_factory=dict)

    def __post_init__(self) -> None:
        """Check that every bound leaves room.

        Raises:
            InputError: an interval is empty or not a number, or a size is not positive.
        """
        for name, interval in self.durations.items():
            _ordered(f"duration of {name}", interval)
            _positive(f"shortest duration of {name}", interval[0])
        for name, interval in self.positions.items():
            _ordered(f"position of {name}", interval)
        for axis, interval in zip("xyz", self.touchdown_velocity, strict=True):
            _ordered(f"touchdown velocity along {axis}", interval)
        for kind, sizes in (("speed", self.speeds), ("torque", self.torques)):
            for name, size in sizes.items():
                _positive(f"largest {kind} of {name}", size)
        _positive("largest acceleration", self.acceleration)
        for what, value in (("normal force", self.normal_force), ("clearance", self.clearance)):
            if not 0.0 <= value < inf:
                raise InputError(f"the least {what} is {value:g}; it must be finite and not negative")
        if self.standing_force is not None and not self.normal_force <= self.standing_force < inf:
            raise InputError(
                f"the least normal force of a foot that stays is {self.standing_force:g}; it must be finite and at "
                f"least the normal force, {self.normal_force:g}"
            )

    def least_normal_force(self, leaves: bool, passed: Vector) -> Vector:
        """Return the bound of a stance foot's normal force along a stance, (n,), N.

        Args:
            leaves: whether the foot leaves by its force at the end.
            passed: share of the stance that has passed, 0 at its entry, 1 at its end, (n,).
        """
        most = self.normal_force if self.standing_force is None else self.standing_force
        return most + (self.normal_force - most) * passed * float(leaves)

    def accelerations(self, robot: Robot) -> dict[str, float]:
        """Return coordinate -> largest |second derivative|, m/s^2 or rad/s^2, as a point a leg away would have it."""
        by_unit = {"m": self.acceleration * robot.leg_length, "rad": self.acceleration}
        return {name: by_unit[unit_of(robot, name)] for name in robot.coordinate_names}


def highest_landing(robot: Robot) -> float:
    """Return the largest normal velocity at which a foot of a robot still comes down, -0.02 sqrt(g l), m/s."""
    return -SLOWEST_LANDING * velocity_unit(robot)


def sensible_rows(limits: Limits, friction: float, robot: Robot) -> tuple[Residual, ...]:
    """Return the bounds that a verdict on a gait rests on as rows: outside their own bounds they are absurd.

    Args:
        limits: bounds of the gait.
        friction: coefficient of its ground.
        robot: its robot.
    """
    gravity = robot.gravity
    least = SMALLEST_TORQUE * robot.mass * gravity * robot.leg_length
    return (
        Residual("sensible gravity", GRAVITY[0], gravity, GRAVITY[1]),
        Residual("sensible friction coefficient", 0.0, friction, LARGEST_FRICTION),
        *(
            Residual(
                f"sensible torque limit of '{joint}'",
                least / float(robot.torque_arms[robot.joint_index(joint)]),
                torque,
                inf,
            )
            for joint, torque in limits.torques.items()
        ),
    )


def _ordered(what: str, interval: Interval) -> None:
    lower, upper = interval
    if not lower <= upper:
        raise InputError(f"the {what} is bounded by {lower:g} to {upper:g}, which leaves no room")


def _positive(what: str, size: float) -> None:
    if not size > 0.0:
        raise InputError(f"the {what} is {size:g}; it must be positive")
