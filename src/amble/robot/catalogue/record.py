"""What the catalogue knows of a robot beside its URDF: a posture to walk in and the bounds its builders used."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from amble.robot.adaptation import Adaptation
from amble.robot.model import Robot
from amble.types import Vector

Interval = tuple[float, float]


@dataclass(frozen=True)
class Posture:
    """A nominal standing or walking posture; the base is level.

    Attributes:
        height: z of the base, m.
        angles: joint name -> angle, rad.
    """

    height: float
    angles: Mapping[str, float]

    def coordinates(self, robot: Robot) -> Vector:
        """Return q of the posture at the world origin, (n_q,)."""
        known = {**dict.fromkeys(robot.base.coordinates, 0.0), **self.angles, "z": self.height}
        return np.array([known[name] for name in robot.coordinate_names])


@dataclass(frozen=True, kw_only=True)
class GaitBounds:
    """Bounds of a published gait problem, SI units and radians.

    Attributes:
        duration: of every domain, (shortest, longest), s.
        torque: largest |torque| of every joint, N m.
        speed: largest |rate| of every joint, rad/s.
        acceleration: largest |second derivative| of an angle, rad/s^2; times the leg length that of x, y and z.
        positions: coordinate name -> (lower, upper), m or rad.
        touchdown_velocity: of a landing foot just before impact, x, y, z -> (lower, upper), m/s.
    """

    duration: Interval
    torque: float
    speed: float
    acceleration: float
    positions: Mapping[str, Interval]
    touchdown_velocity: tuple[Interval, Interval, Interval]


@dataclass(frozen=True)
class Entry:
    """One robot of the catalogue: how to load it, how it stands, and the bounds of its builders' gait."""

    load: Callable[[Adaptation], Robot]
    posture: Posture
    bounds: GaitBounds
