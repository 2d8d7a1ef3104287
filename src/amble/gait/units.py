"""Units of a legged robot's coordinates, states and signals."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amble.gait.record import Gait
from amble.robot import Robot
from amble.robot.model import RATE
from amble.types import Vector

LENGTHS = ("x", "y", "z")
"""Coordinates in m; all others are in rad."""

SIGNALS = {"torque": "N m", "force": "N", "foot": "m", "foot_velocity": "m/s", "pivot": "1"}
"""Signals that the closed loop of a gait records."""


def unit_of(coordinate: str, per_second: str = "") -> str:
    """Return the unit of a coordinate, or of its derivative."""
    return ("m" if coordinate in LENGTHS else "rad") + per_second


def units(coordinates: Sequence[str], per_second: str = "") -> list[str]:
    """Return the unit of every coordinate, or of its derivative."""
    return [unit_of(name, per_second) for name in coordinates]


def trace_units(gait: Gait) -> dict[str, str]:
    """Return name -> unit of the states and signals of the gait's closed loop, as traces hold them."""
    names = gait.robot.coordinate_names
    rates = [f"{RATE}{name}" for name in names]
    return {
        **dict(zip(names, units(names), strict=True)),
        **dict(zip(rates, units(names, "/s"), strict=True)),
        **SIGNALS,
    }


def natural_units(robot: Robot, length: float) -> Vector:
    """Return the unit of every state of a robot: lengths by a length l, time by sqrt(l / g), (2 n_q,).

    Args:
        robot: the robot; its gravity is positive.
        length: l, m.
    """
    rate = np.sqrt(robot.gravity / length)
    positions = np.where([name in LENGTHS for name in robot.coordinate_names], length, 1.0)
    return np.concatenate([positions, rate * positions])
