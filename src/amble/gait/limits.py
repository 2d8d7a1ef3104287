"""What a gait must keep to: bounds on durations, states, torques and contacts. Read by synthesis and by the check."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

Interval = tuple[float, float]


@dataclass(frozen=True)
class Limits:
    """Bounds of a gait problem, SI units and radians; contact quantities in the world frame.

    Attributes:
        durations: domain name -> (shortest, longest) duration, s.
        positions: coordinate name (z, roll, pitch, yaw and every joint) -> (lower, upper), m or rad.
        speeds: joint name -> largest |rate|, rad/s.
        torques: joint name -> largest |torque|, N m.
        acceleration: largest |second derivative| of any coordinate, m/s^2 or rad/s^2.
        touchdown_velocity: velocity of a landing foot just before the impact, x, y, z -> (lower, upper), m/s.
        friction: friction coefficient mu; the gait problem uses the inner pyramid |f_x|, |f_y| <= mu f_z / sqrt(2).
        normal_force: smallest normal force of a stance foot, N.
        clearance: height that every swing foot exceeds at the middle of its swing, m.
    """

    durations: Mapping[str, Interval]
    positions: Mapping[str, Interval]
    speeds: Mapping[str, float]
    torques: Mapping[str, float]
    acceleration: float
    touchdown_velocity: tuple[Interval, Interval, Interval]
    friction: float
    normal_force: float
    clearance: float
