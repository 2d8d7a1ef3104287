"""How long walks last from changed starts: cycles that a gait completes, by the size of the change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.progress import Progress, ProgressReport, silent
from amble.robot.natural_units import natural_units
from amble.simulation import simulate
from amble.simulation.simulate import perturbed

TOLERANCE = 1e-8
"""Of the integrator."""


def survived_cycles(
    gait: Gait, sizes: Sequence[float], starts: int = 10, cycles: int = 20, progress: Progress | None = None
) -> Mapping[float, tuple[int, ...]]:
    """Walk a gait from starts of which every state is changed, up or down at random, and count completed cycles.

    A state is changed by ``size`` of its unit: lengths by the leg length l, times by sqrt(l / g).

    Args:
        gait: the gait.
        sizes: of the changes.
        starts: of each size, at least 1; their seeds are 0, 1, ...
        cycles: the most a walk is followed.
        progress: called before every walk.

    Returns:
        Size -> completed cycles of each of its walks.

    Raises:
        InputError: fewer than one start, or a size that is negative or not finite.
    """
    if starts < 1:
        raise InputError(f"{starts} starts were asked for; at least 1 is needed")
    if not all(0.0 <= size < np.inf for size in sizes):
        raise InputError("sizes of changes are finite and not negative")
    notify, system, state = progress or silent, closed_loop(gait), start_state(gait)
    units = natural_units(gait.robot, gait.robot.leg_length)
    found: dict[float, tuple[int, ...]] = {}
    for size in sizes:
        done = []
        for seed in range(starts):
            notify(ProgressReport(what=f"start changed by {size:g}, seed {seed}", done=seed, of=starts))
            start = state + units * perturbed(np.zeros(len(state)), size, seed)
            done.append(simulate(system, start, cycles, TOLERANCE).cycles)
        found[float(size)] = tuple(done)
    return found
