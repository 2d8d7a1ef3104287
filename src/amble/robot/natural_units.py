"""Natural units of a legged robot: lengths by a length l of it, times by sqrt(l / g), forces by its weight."""

from __future__ import annotations

import re
from dataclasses import dataclass

import numpy as np

from amble.errors import InputError, shown
from amble.robot.coordinate_units import is_length
from amble.robot.model import Robot
from amble.types import Vector

LENGTH, MASS, TIME = 1.141, 0.0465, 3.346
"""Units of a robot: lengths in leg lengths l, masses in m, times in sqrt(l / g). ASTRo's are a metre, a kilogram and a
second, so that sizes found good for it are good for every robot in its own units."""

BASE_UNITS = {"1": (0, 0, 0), "rad": (0, 0, 0), "m": (1, 0, 0), "kg": (0, 1, 0), "s": (0, 0, 1)}
KNOWN_UNITS = {**BASE_UNITS, "N": (1, 1, -2), "J": (2, 1, -2), "W": (2, 1, -3)}
"""Unit -> powers of length, mass and time."""

FACTOR = re.compile(r"([A-Za-z]+|1)(?:\^([1-9]))?")


@dataclass(frozen=True, kw_only=True)
class RobotUnits:
    """Sizes of one unit of length, m, mass, kg, and time, s, for a robot.

    Two robots that differ only in size and weight have the same numbers in their own units. Factors that are powers of
    two, of four for lengths, change no digit of them: only products, quotients and square roots occur here.
    """

    length: float
    mass: float
    time: float

    @classmethod
    def of(cls, robot: Robot) -> RobotUnits:
        """Return the units of a robot; errors as in ``natural_units``."""
        _check(robot, robot.leg_length)
        time = TIME * float(np.sqrt(robot.leg_length / robot.gravity))
        return cls(length=LENGTH * robot.leg_length, mass=MASS * robot.mass, time=time)

    def size(self, unit: str) -> float:
        """Return the size in SI units of a unit's dimension, such as that of a torque for "N m".

        Args:
            unit: factors of 1, rad, m, kg, s, N, J and W with powers from 1 to 9; those behind a slash divide.

        Raises:
            InputError: it is nothing of that kind.
        """
        above, _, below = unit.partition("/")
        result = 1.0
        for words, sign in ((above, 1), (below, -1)):
            for factor in words.split():
                match = FACTOR.fullmatch(factor)
                if match is None or match[1] not in KNOWN_UNITS:
                    raise InputError(f"'{shown(unit)}' is no product of powers of {', '.join(KNOWN_UNITS)}")
                powers = (sign * int(match[2] or 1) * power for power in KNOWN_UNITS[match[1]])
                for base, power in zip((self.length, self.mass, self.time), powers, strict=True):
                    for _ in range(abs(power)):  # pow() may round otherwise at another size
                        result = result * base if power > 0 else result / base
        return result


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
    positions = np.where([is_length(robot, name) for name in robot.coordinate_names], length, 1.0)
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
