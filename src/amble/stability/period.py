"""After how many cycles an orbit closes."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amble.hybrid import HybridSystem
from amble.simulation.walk import walk
from amble.stability.group import closest_shift
from amble.types import Matrix, Vector

MOST_TURNS = 4
"""Up to so many times the cycles that were asked for a guess is tried for a return."""

RETURNS = 1e-3
"""A guess returns where it comes back this much closer to itself than the fixed point is that was found."""

SMALLEST = 1e-6
"""Nearer to the guess a fixed point is taken for the one that was meant, relative to 1 + |x|."""

LOOSE = 1e3
"""Times the accuracy: how exactly a state returns after a part of its cycles."""

TOLERANCE = 1e-10


def least_cycles(system: HybridSystem, state: Vector, entries: Sequence[Vector], accuracy: float) -> int:
    """Return after how many cycles a fixed point of a map of several returns.

    Args:
        system: the system.
        state: the fixed point, (n_x,).
        entries: states after every cycle, the last of them the fixed point again up to the symmetries.
        accuracy: of the fixed point.
    """
    total = len(entries)
    for count in range(1, total):
        if total % count == 0 and _distance(system, state, entries[count - 1]) <= LOOSE * accuracy:
            return count
    return total


def other_period(
    system: HybridSystem,
    guess: Vector,
    found: Vector,
    matrix: Matrix,
    cycles: int,
    time_limit: float,
    max_step: float | None,
) -> str:
    """Say that a guess lies on an orbit of more cycles than those of the fixed point to which Newton went; else empty.

    A guess that returns because the found orbit is neutral that way (linear theory at it explains the return) does not
    count.

    Args:
        system: the system.
        guess: where Newton began, (n_x,).
        found: the fixed point of the map of ``cycles`` cycles, (n_x,).
        matrix: its derivative there, (n_x, n_x).
        cycles: that were asked for.
        time_limit: the longest that one domain may last, s.
        max_step: the longest time between two event samples, s.
    """
    moved = _distance(system, found, guess)
    if moved <= SMALLEST * (1.0 + float(np.linalg.norm(found))):
        return ""
    motion = walk(system, guess, MOST_TURNS * cycles, TOLERANCE, 2, time_limit, max_step=max_step)
    first = system.domains[0].name
    entries = [event.after for event in motion.events if event.transition in _entering(system, first)]
    deviation = guess - closest_shift(system, found, guess).image
    for turns in range(2, MOST_TURNS + 1):
        if len(entries) < turns * cycles:
            break
        missed = _distance(system, guess, entries[turns * cycles - 1])
        explained = np.linalg.norm(np.linalg.matrix_power(matrix, turns) @ deviation - deviation)
        if missed <= RETURNS * moved and explained > 10.0 * RETURNS * moved:
            return (
                f"the guess returns after {turns * cycles} cycles, and Newton left it for an orbit that returns after "
                f"{cycles}, {moved:.2g} away: for the former give cycles={turns * cycles}, for the latter a guess "
                "nearer to it"
            )
    return ""


def _entering(system: HybridSystem, name: str) -> set[str]:
    return {transition.name for transition in system.transitions if transition.target == name}


def _distance(system: HybridSystem, state: Vector, other: Vector) -> float:
    return float(np.linalg.norm(other - closest_shift(system, state, other).image))
