"""A log of a robot against its gait: how closely the joints follow, at which pace, and with what torques.

A log is a table of times, joint angles and, where it has them, torques. It is taken to walk the gait over and over: it
is held against the gait's cycle, stretched by a factor and shifted in time so that the joint angles differ least.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from amble.analysis.samples import samples_of_gait
from amble.errors import InputError, printable, shown
from amble.gait import Gait
from amble.io.reader import parse_number
from amble.io.table import read_table
from amble.types import Json, Matrix, NodeValues, Vector, frozen

SLOWEST, FASTEST, PACES, SHIFTS = 0.7, 1.4, 57, 60
"""Periods over the gait's that are looked at, and how many of them and of shifts in time, before both are refined."""

FEWEST = 10

ENOUGH, REFINED = 2000, 40_000
"""Samples on which pace and phase are searched for, and on which they are refined; errors are those of all of them."""

LARGEST = 1e9
"""Number of a log: s, rad, N m."""


@dataclass(frozen=True, kw_only=True)
class Log:
    """What a robot recorded.

    Attributes:
        times: ascending, (n,), s.
        angles: of the joints, in the robot's order, (n, n_joints), rad.
        torques: of the joints, (n, n_joints), N m; None where the log has none.
    """

    times: Vector
    angles: NodeValues
    torques: NodeValues | None


@dataclass(frozen=True, kw_only=True)
class LogComparison:
    """A log beside its gait.

    Attributes:
        samples: of the log.
        seconds: that it lasts.
        period: of the walk, s.
        planned: period of the gait, s.
        errors: joint -> root mean square of its angle less the gait's, rad.
        largest: joint -> largest size of that, rad.
        rms_torque: over all joints and samples, N m; None where the log has no torques.
        planned_torque: the same of the gait's own torques, N m.
    """

    samples: int
    seconds: float
    period: float
    planned: float
    errors: Mapping[str, float]
    largest: Mapping[str, float]
    rms_torque: float | None
    planned_torque: float

    def to_dict(self) -> Json:
        """Return it as a dictionary for a JSON file."""
        return {**vars(self), "errors": dict(self.errors), "largest": dict(self.largest)}


def read_log(path: str | Path, gait: Gait) -> Log:
    """Read a log: CSV with a line of names, "time" and every joint's, and "torque JOINT" for all or no joint.

    Raises:
        InputError: in one sentence: the file is missing or no table, a column is missing, a cell is no number, the
            times do not ascend, or there are fewer than ten samples.
    """
    name = f"log '{printable(Path(path).name)}'"
    rows = read_table(path, "log")[1]
    header, joints = [cell.strip() for cell in rows[0]] if rows else [], gait.robot.joint_names
    torques = [f"torque {joint}" for joint in joints]
    wanted = ["time", *joints, *(torques if any(label in header for label in torques) else [])]
    for label in wanted:
        if header.count(label) != 1:
            raise InputError(f"{name} has {header.count(label)} columns '{shown(label)}' in its first line, not one")
    places = [header.index(label) for label in wanted]
    lines = [number for number, row in enumerate(rows[1:], start=2) if row]
    values = [_numbers(name, rows[number - 1], places, number) for number in lines]
    table = np.array(values).reshape(len(values), len(wanted))
    large = np.flatnonzero(~np.all(np.abs(table) <= LARGEST, axis=1))
    if large.size:
        raise InputError(f"{name}, line {lines[large[0]]} holds a number that is not finite or above {LARGEST:g}")
    if len(table) < FEWEST or not np.all(np.diff(table[:, 0]) > 0.0):
        raise InputError(f"{name} needs {FEWEST} samples or more, their times ascending; it has {len(table)}")
    angles, rest = table[:, 1 : 1 + len(joints)], table[:, 1 + len(joints) :]
    return Log(times=frozen(table[:, 0]), angles=frozen(angles), torques=frozen(rest) if rest.size else None)


def _numbers(name: str, row: list[str], places: list[int], line: int) -> list[float]:
    try:
        return [parse_number(row[place].strip()) for place in places]
    except (IndexError, ValueError) as error:
        raise InputError(f"{name}, line {line}: {error}") from None


def compare_log(gait: Gait, log: Log) -> LogComparison:
    """Hold a log against a gait.

    Args:
        gait: the gait.
        log: of at least half a cycle.

    Raises:
        InputError: the log is shorter than half a cycle of the gait, so that its pace cannot be told.
    """
    from scipy.optimize import minimize

    cycle, lasting = samples_of_gait(gait), float(log.times[-1] - log.times[0])
    if not lasting >= 0.5 * gait.period:
        raise InputError(f"the log lasts {lasting:.3g} s, less than half a cycle of the gait ({gait.period:.3g} s)")
    joints, arms = gait.robot.joint_names, gait.robot.torque_arms
    shares, first = (cycle.times - cycle.times[0]) / gait.period, len(joints)
    angles = cycle.positions[:, -first:]

    def differing(pace: float, shift: float, stride: int = 1) -> Matrix:
        places = ((log.times[::stride] - log.times[0]) / (pace * gait.period) + shift) % 1.0
        planned = np.column_stack([np.interp(places, shares, column) for column in angles.T])
        return np.asarray(log.angles[::stride] - planned)

    def size(found: Vector, stride: int = 1) -> float:
        return float(np.sqrt(np.mean(differing(float(found[0]), float(found[1]), stride) ** 2)))

    tried = [(pace, shift) for pace in np.geomspace(SLOWEST, FASTEST, PACES) for shift in np.arange(SHIFTS) / SHIFTS]
    few = -(-len(log.times) // ENOUGH)
    start = min(tried, key=lambda pair: size(np.array(pair), few))
    most = -(-len(log.times) // REFINED)
    best = minimize(size, np.array(start), (most,), method="Nelder-Mead", options={"xatol": 1e-7, "fatol": 1e-9}).x
    left = differing(float(best[0]), float(best[1]))
    return LogComparison(
        samples=len(log.times),
        seconds=lasting,
        period=float(best[0]) * gait.period,
        planned=gait.period,
        errors=dict(zip(joints, map(float, np.sqrt(np.mean(left**2, axis=0))), strict=True)),
        largest=dict(zip(joints, map(float, np.abs(left).max(axis=0)), strict=True)),
        rms_torque=None if log.torques is None else float(np.sqrt(np.mean((arms * log.torques) ** 2))),
        planned_torque=_rms(cycle.times, arms * cycle.torques),
    )


def _rms(times: Vector, torques: NodeValues) -> float:
    """Root mean square over time, by the trapezoidal rule, and over the joints."""
    squares = np.mean(torques**2, axis=1)
    return float(np.sqrt(np.trapezoid(squares, times) / (times[-1] - times[0])))
