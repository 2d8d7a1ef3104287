"""A trial of weights where feet land one by one: do changed starts come back? It decides how large weights may be."""

from __future__ import annotations

from collections.abc import Callable
from typing import Protocol, TypeVar

import numpy as np

from amble.errors import WorkError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.progress import Progress, ProgressReport
from amble.robot.natural_units import natural_units
from amble.simulation import simulate
from amble.simulation.simulate import perturbed

PENALTIES = 1e-2, 3e-2, 1e-1, 2e-1
"""Weights of |theta|^2 beside log r, ascending: the derivatives leave out how long feet stay apart, which large weights
turn into torques. The first is taken under which every start of the trial comes back; which it is depends on the robot:
ASTRo's trot needs 1e-2, Go2's 2e-1 (docs/decisions.md)."""

TRIED, CHANGE, CYCLES = 16, 1e-2, 20
"""Seeded starts, what every state of theirs is changed by, in its unit, and the cycles they walk."""


def came_back(gait: Gait) -> int:
    """Walk from changed starts and count those that walk all cycles."""
    system, start = closed_loop(gait), start_state(gait)
    units, still = natural_units(gait.robot, gait.robot.leg_length), np.zeros(start.size)
    starts = (start + units * perturbed(still, CHANGE, seed) for seed in range(TRIED))
    return sum(simulate(system, changed, CYCLES, samples=2).completed for changed in starts)


class HasGait(Protocol):
    """What a stabilisation returns."""

    @property
    def gait(self) -> Gait:
        """The stabilised gait."""


Found = TypeVar("Found", bound=HasGait)


def by_trial(stabilised: Callable[[float], Found], notify: Progress) -> Found:
    """Stabilise with ascending penalties until every start comes back; else return that from which most do.

    Args:
        stabilised: penalty -> a stabilised gait; errors of the first are raised.
        notify: called before every trial.
    """
    best = stabilised(PENALTIES[0])
    most = _tried(best, notify)
    for penalty in PENALTIES[1:]:
        if most == TRIED:
            break
        try:
            found = stabilised(penalty)
        except WorkError:  # the orbit stays unstable under smaller weights
            break
        came = _tried(found, notify)
        if came > most:
            best, most = found, came
    return best


def _tried(found: HasGait, notify: Progress) -> int:
    notify(ProgressReport(what=f"{TRIED} starts changed by {CHANGE:g}"))
    return came_back(found.gait)
