"""Natural units of a legged robot: lengths by a length l of it, times by sqrt(l / g), forces by its weight."""

from __future__ import annotations

import numpy as np

from amble.errors import InputError
from amble.io.quantities import LENGTHS
from amble.robot.model import Robot
from amble.types import Vector


def natural_units(robot: Robot, length: float) -> Vector:
    """Return the unit of every state of a robot: lengths by a length l, time by sqrt(l / g), (2 n_q,).

    Args:
        robot: the robot.
        length: l, m.

    Raises:
        InputError: mass or length is zero, so that there are no such units.
    """
    _check(robot, length)
    rate = np.sqrt(robot.gravity / length)
    positions = np.where([name in LENGTHS for name in robot.coordinate_names], length, 1.0)
    return np.concatenate([positions, rate * positions])


def velocity_unit(robot: Robot) -> float:
    """Return sqrt(g l) of the leg length l, m/s; errors as in ``natural_units``."""
    _check(robot, robot.leg_length)
    return float(np.sqrt(robot.gravity * robot.leg_length))


def _check(robot: Robot, length: float) -> None:
    sizes = {"mass (kg)": robot.mass, "leg length (m)": length}
    for what, size in sizes.items():
        if not size > 0.0:
            raise InputError(f"the {what} of robot '{robot.name}' is {size:g}, so nothing of it can be measured by it")
