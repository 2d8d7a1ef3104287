"""Limits of a gait that fit a robot: those of its builders, or scaled by its size and weight."""

from __future__ import annotations

from collections.abc import Mapping
from math import isfinite, radians, sqrt

from amble.gait import Limits
from amble.gait.limits import SLOWEST_LANDING, Interval
from amble.hybrid import GaitPattern, Switch
from amble.robot import Robot, catalogue
from amble.robot.catalogue import GaitBounds, Posture
from amble.robot.natural_units import velocity_unit
from amble.robot.proposal import bent_ranges, nominal_posture

STANDING = 0.1
"""Least normal force of a foot that stays, in weights. With 2.4 % the rear foot of Mini Cheetah's walk carried 3 % all
along its last stance, and left at once after a change of 1e-4."""

OFF_STRAIGHT = radians(15.0)
"""Least bend of knees by default, rad."""

ACCELERATION = 18.0
"""Largest acceleration of joints by default, in g / l. A leg that is pulled up and put down in one domain needs it:
with half as much Go2's pronk, HyQ's bound and Solo8's trot have no solution, and Mini Cheetah's trot three times the
torque."""

LIFT_OFF = 0.15
"""Shortest stance by default that ends as feet leave by their force, in sqrt(l / g). ANYmal C's walk had one of 0.05,
in which a force fell from half the weight to 2 %, and starts changed by 1e-4 fell."""

CLEARANCE = 0.08
"""Height of swing feet at the middle of their swing by default, as a share of the leg length."""


def default_limits(pattern: GaitPattern, posture: Posture | None = None, yaw_rate: float = 0.0) -> Limits:
    """Return limits that fit a robot, to change by ``dataclasses.replace``.

    For a robot of the catalogue they are its builders' own, with 5 N of normal force and 20 mm of clearance. For any
    other, joint limits come from its description, and the rest follows from size and weight, with l the leg length, m
    the mass and g gravity: durations from 0.05 to 0.75 sqrt(l / g), from 0.15 where feet leave by their force at the
    end, accelerations up to 18 g / l, a touchdown slower than 0.15 sqrt(g l) forward, 0.05 sideways and
    0.45 downward, there faster than 0.02, normal forces from 2.4 % of m g, from 10 % of feet that stay, swing feet
    above 8 % of l, roll and pitch within 0.1 rad, knees at least 15 degrees off straight and bent as at the posture.
    Without these the smallest torques are those of straight legs whose feet hardly rise.

    Args:
        pattern: the gait pattern, with the robot.
        posture: how the robot stands; by default as in ``gait_problem``.
        yaw_rate: mean rate of the heading, rad/s; the range of yaw grows by the largest turn of a cycle.
    """
    robot = pattern.robot
    if catalogue.holds(robot):
        bounds, normal_force, clearance, standing = catalogue.bounds(robot.name), 5.0, 0.02, None
        torques = dict.fromkeys(robot.joint_names, bounds.torque)
        speeds = dict.fromkeys(robot.joint_names, bounds.speed)
    else:
        bounds = _scaled(robot, posture or nominal_posture(robot))
        weight = robot.mass * robot.gravity
        normal_force, clearance, standing = 0.024 * weight, CLEARANCE * robot.leg_length, STANDING * weight
        torques = {joint.name: joint.effort for joint in robot.joints if isfinite(joint.effort)}
        speeds = {joint.name: joint.velocity for joint in robot.joints if isfinite(joint.velocity)}
    return Limits(
        durations={switch.source.name: _duration(robot, switch, bounds.duration) for switch in pattern.switches},
        positions=_turning(bounds.positions, yaw_rate * bounds.duration[1] * len(pattern.solved)),
        speeds=speeds,
        torques=torques,
        acceleration=bounds.acceleration,
        touchdown_velocity=bounds.touchdown_velocity,
        normal_force=normal_force,
        clearance=clearance,
        standing_force=standing,
    )


def _duration(robot: Robot, switch: Switch, bounds: Interval) -> Interval:
    """Bounds of the duration of the stance that a switch ends; a force takes its time to fall."""
    if not switch.leaving or catalogue.holds(robot):
        return bounds
    return (max(bounds[0], LIFT_OFF * sqrt(robot.leg_length / robot.gravity)), bounds[1])


def _turning(positions: Mapping[str, Interval], turn: float) -> Mapping[str, Interval]:
    """Widen the range of yaw by a turn."""
    if not turn or "yaw" not in positions:
        return positions
    low, high = positions["yaw"]
    return {**positions, "yaw": (low + min(turn, 0.0), high + max(turn, 0.0))}


def _scaled(robot: Robot, posture: Posture) -> GaitBounds:
    """Bounds by dimension: times in sqrt(l / g), velocities in sqrt(g l); ASTRo's own are of this size."""
    # shorthand
    velocity, length, g, z = velocity_unit(robot), robot.leg_length, robot.gravity, posture.height
    time = sqrt(length / g)

    def within(lower: float, upper: float, size: float) -> Interval:
        return (lower * size, upper * size)

    base = {"z": within(0.6, 1.4, z), "roll": (-0.1, 0.1), "pitch": (-0.1, 0.1), "yaw": (-0.3, 0.3)}
    return GaitBounds(
        duration=within(0.05, 0.75, time),
        torque=float("inf"),
        speed=float("inf"),
        acceleration=ACCELERATION * g / length,
        positions={
            **{name: bounds for name, bounds in base.items() if name in robot.base.coordinates},
            **{joint.name: (joint.lower, joint.upper) for joint in robot.joints},
            **bent_ranges(robot, posture.angles, OFF_STRAIGHT),
        },
        touchdown_velocity=(
            within(-0.15, 0.15, velocity),
            within(-0.05, 0.05, velocity),
            within(-0.45, -SLOWEST_LANDING, velocity),
        ),
    )
