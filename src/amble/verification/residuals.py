"""What a check found: residuals with their bounds, where the worst value occurred, and what is accepted.

Residuals are measured by the size of a recorded quantity, never less than a share of the robot's natural unit. Lengths
count by the leg length l, rates by sqrt(g / l), forces by the weight W, so that one tolerance means the same for robots
of 100 g and of a tonne.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from amble.hybrid import Contacts
from amble.residual import HEADER, Residual, listing, worst_first, worst_of_kinds
from amble.robot import Robot
from amble.robot.natural_units import natural_units
from amble.types import Matrix, Vector, frozen

RATE, ACCELERATION, LOAD = 0.3, 0.1, 0.005
"""Shares of the natural units sqrt(g / l), g / l and W that count although nothing recorded is so large: about 1 m/s,
1 m/s^2, 1 N and 1 N m for a dog of 20 kg."""


@dataclass(frozen=True)
class CheckReport:
    """The result of a check: the worst value of every checked quantity in every domain and switch.

    Attributes:
        rows: all of them, in the order of the domains; times are clocks of the domains.
        points: number of points along all domains that were looked at.
        tolerance: bound of every residual whose bounds are a tolerance.
    """

    rows: tuple[Residual, ...]
    points: int
    tolerance: float

    @property
    def failed(self) -> tuple[Residual, ...]:
        """The rows that fail, worst first inside their kind."""
        kinds = list(dict.fromkeys(row.kind for row in self.rows))
        bad = worst_first(row for row in self.rows if not row.passed)
        return tuple(sorted(bad, key=lambda row: kinds.index(row.kind)))

    @property
    def passed(self) -> bool:
        """Whether no row fails."""
        return all(row.passed for row in self.rows)

    @property
    def worst(self) -> dict[str, Residual]:
        """Kind -> the row that is nearest to failing, or fails worst."""
        return worst_of_kinds(self.rows)

    def __str__(self) -> str:
        """The worst row of every kind, then every row that fails."""
        lines = [f"{HEADER}   worst row of each kind", listing(tuple(self.worst.values())), ""]
        if self.failed:
            lines += [f"{len(self.failed)} of {len(self.rows)} rows fail:", listing(self.failed)]
        else:
            lines.append(f"all {len(self.rows)} rows hold at {self.points} points")
        return "\n".join(lines)


def residuals(
    kind: str, names: Sequence[str], values: Matrix, times: Vector, tolerance: float, scale: Vector | float = 1.0
) -> list[Residual]:
    """Return one row a column of residuals: the largest in size, signed, divided by the scale.

    Args:
        kind: kind of the quantity.
        names: name of every column.
        values: (points, columns).
        times: clock of every point, (points,), s; NaN where the quantity has no time.
        tolerance: bound of the scaled residual.
        scale: what the residuals are divided by, one for all or one a column.
    """
    found = []
    for name, column in zip(names, (np.asarray(values).reshape(len(times), len(names)) / scale).T, strict=True):
        place = int(np.argmax(np.where(np.isnan(column), np.inf, np.abs(column))))
        value, time = float(column[place]), _time(times[place])
        found.append(Residual(name, -tolerance, value, tolerance, kind=kind, time=time))
    return found


def limit(kind: str, name: str, values: Vector, times: Vector, bounds: tuple[float, float], slack: float) -> Residual:
    """Return the row of the value that leaves its bounds furthest, or comes closest to one of them.

    Args:
        kind: kind of the quantity.
        name: name of the row.
        values: (points,).
        times: clock of every point, (points,), s; NaN where the quantity has no time.
        bounds: lower and upper bound.
        slack: how far a value may leave its bounds.
    """
    lower, upper = bounds
    excess = np.maximum(lower - values, values - upper)
    place = int(np.argmax(np.where(np.isnan(excess), np.inf, excess)))
    return Residual(name, lower, float(values[place]), upper, kind=kind, slack=slack, time=_time(times[place]))


def _time(clock: float) -> float | None:
    return None if np.isnan(clock) else float(clock)


@dataclass(frozen=True, kw_only=True)
class Sizes:
    """Smallest sizes of what is recorded of a robot.

    Attributes:
        positions: of every coordinate, l or 1 rad, (n_q,).
        rates: of their rates, (n_q,).
        accelerations: of their accelerations, (n_q,).
        force: N.
        torque: N m.
        torques: of every joint, N m, or N of prismatic ones, (n_joints,).
        impulse: N s.
        loads: of the rows of the equations of motion, N and N m, (n_q,).
    """

    positions: Vector
    rates: Vector
    accelerations: Vector
    force: float
    torque: float
    torques: Vector
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
    length, gravity = robot.leg_length, robot.gravity
    positions, rates = np.split(natural_units(robot, length), 2)
    force = LOAD * robot.mass * gravity
    return Sizes(
        positions=frozen(positions),
        rates=frozen(RATE * rates),
        accelerations=frozen(ACCELERATION * gravity / length * positions),
        force=force,
        torque=force * length,
        torques=frozen(force * length / robot.torque_arms),
        impulse=force * float(np.sqrt(length / gravity)),
        loads=frozen(force * length / positions),
    )


def of_contacts(contacts: Contacts, linear: float, angular: float) -> Vector:
    """Return the sizes of stacked components of contacts, (n_f,): those along axes, and of moments or turns."""
    each = [linear] * len(contacts.contact.axes) + [angular] * len(contacts.contact.moments)
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
