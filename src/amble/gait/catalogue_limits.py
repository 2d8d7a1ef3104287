"""Limits of a gait of a robot of the catalogue: its builders' own bounds."""

from __future__ import annotations

from amble.gait.limits import Interval, Limits
from amble.hybrid import GaitPattern
from amble.robot import catalogue


def catalogue_limits(
    name: str,
    pattern: GaitPattern,
    normal_force: float,
    clearance: float,
    friction: float = 0.6,
    duration: Interval | None = None,
) -> Limits:
    """Return the builders' bounds of a robot of the catalogue as limits of a gait.

    Args:
        name: of the robot in the catalogue.
        pattern: the gait pattern.
        normal_force: smallest normal force of a stance foot, N.
        clearance: height that every swing foot exceeds at the middle of its swing, m.
        friction: coefficient.
        duration: shortest and longest duration of every domain, s; the builders' own where not given.

    Raises:
        UnknownNameError: the catalogue has no such robot.
    """
    bounds = catalogue.bounds(name)
    joints = pattern.robot.joint_names
    return Limits(
        durations={stance.name: duration or bounds.duration for stance in pattern.solved},
        positions=bounds.positions,
        speeds=dict.fromkeys(joints, bounds.speed),
        torques=dict.fromkeys(joints, bounds.torque),
        acceleration=bounds.acceleration,
        touchdown_velocity=bounds.touchdown_velocity,
        friction=friction,
        normal_force=normal_force,
        clearance=clearance,
    )
