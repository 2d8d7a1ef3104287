"""What residuals are measured by: the size of a recorded quantity, never less than a share of the robot's natural unit.

Lengths count by the leg length l, rates by sqrt(g / l), forces by the weight W, so that one tolerance means the same
for robots of 100 g and of a tonne.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from amble.hybrid import Contacts
from amble.hybrid.contact import AXES
from amble.robot import Robot
from amble.robot.natural_units import natural_units
from amble.types import Matrix, Vector, frozen

RATE, ACCELERATION, LOAD = 0.3, 0.1, 0.005
"""Shares of the natural units sqrt(g / l), g / l and W that count although nothing recorded is so large: about 1 m/s,
1 m/s^2, 1 N and 1 N m for a dog of 20 kg."""


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Smallest sizes of what is recorded of a robot.

    Attributes:
        positions: of every coordinate, l or 1 rad, (n_q,).
        rates: of their rates, (n_q,).
        accelerations: of their accelerations, (n_q,).
        force: N.
        torque: N m.
        impulse: N s.
        loads: of the rows of the equations of motion, N and N m, (n_q,).
    """

    positions: Vector
    rates: Vector
    accelerations: Vector
    force: float
    torque: float
    impulse: float
    loads: Vector

    @property
    def length(self) -> float:
        """l, m."""
        return float(self.positions[0])

    @property
    def velocity(self) -> float:
        """Of a linear velocity, m/s."""
        return float(self.rates[0])


@lru_cache(maxsize=16)
def sizes(robot: Robot) -> Sizes:
    """Return the smallest sizes for a robot."""
    length, gravity = robot.leg_length, abs(robot.gravity)
    positions, rates = np.split(natural_units(robot, length), 2)
    force = LOAD * robot.mass * gravity
    return Sizes(
        positions=frozen(positions),
        rates=frozen(RATE * rates),
        accelerations=frozen(ACCELERATION * gravity / length * positions),
        force=force,
        torque=force * length,
        impulse=force * float(np.sqrt(length / gravity)),
        loads=frozen(force * length / positions),
    )


def of_contacts(contacts: Contacts, linear: float, angular: float) -> Vector:
    """Return the sizes of stacked components of contacts, (n_f,): those along axes, and of moments or turns."""
    each = [linear] * len(AXES) + [angular] * len(contacts.contact.moments)
    return np.tile(each, len(contacts.feet))


def size_of(values: Matrix, smallest: Vector | float) -> Vector:
    """Return the scale of residuals: the smallest size, made larger by the largest recorded share of it.

    Args:
        values: recorded, columns as ``smallest``.
        smallest: of every column, or of all.

    Returns:
        One a column, or one for all, (1,).
    """
    unit = np.atleast_1d(np.asarray(smallest, dtype=np.float64))
    return np.asarray(unit * (1.0 + float(np.max(np.abs(values) / unit, initial=0.0))))
