"""How long walks last from changed starts: cycles completed with sound contacts, by the size of the change."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from amble.amounts import check_amount
from amble.analysis.bounds import ContactBounds
from amble.analysis.contact import contact_report
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.plant_errors import PlantErrors
from amble.gait.unilateral_loop import unilateral_loop
from amble.gait.unilateral_state import unilateral_start
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport, silent
from amble.robot.natural_units import natural_units
from amble.simulation import Trace, simulate
from amble.simulation.simulate import perturbed
from amble.types import Vector

MOST_STARTS = 10_000

TOLERANCE = 1e-8
"""Of the integrator."""


def survived_cycles(
    gait: Gait,
    sizes: Sequence[float],
    starts: int = 10,
    cycles: int = 20,
    progress: Progress | None = None,
    friction: float | None = None,
) -> Mapping[float, tuple[int, ...]]:
    """Walk a gait from starts of which every state is changed, up or down at random, and count completed cycles.

    A state is changed by ``size`` of its unit: lengths by the leg length l, times by sqrt(l / g). Contacts are
    unilateral (``unilateral_loop``): feet that pull are released, and a walk ends where a foot leaves its friction
    cone. Where the gait turns, it ends with the first cycle in which a foot pulls or leaves its cone.

    Args:
        gait: the gait.
        sizes: of the changes.
        starts: of each size, from 1 to 10,000; their seeds are 0, 1, ...
        cycles: the most a walk is followed.
        progress: called before every walk.
        friction: of the ground that is walked on; the gait's own by default.

    Returns:
        Size -> completed cycles of each of its walks.

    Raises:
        InputError: starts or cycles are out of range, or a size that is negative or not finite.
    """
    check_amount("starts", starts, 1, MOST_STARTS)
    if not all(0.0 <= size < np.inf for size in sizes):
        raise InputError("sizes of changes are finite and not negative")
    notify, state, bounds = progress or silent, start_state(gait), ContactBounds.of_gait(gait)
    bounds = bounds if friction is None else replace(bounds, friction=friction)
    unilateral = not gait.turn
    system = unilateral_loop(gait, errors=PlantErrors(friction=bounds.friction)) if unilateral else closed_loop(gait)
    units = natural_units(gait.robot, gait.robot.leg_length)
    found: dict[float, tuple[int, ...]] = {}
    for size in sizes:
        done = []
        for seed in range(starts):
            notify(ProgressReport(what=f"start changed by {size:g}, seed {seed}", done=seed, of=starts))
            start = state + units * perturbed(np.zeros(len(state)), size, seed)
            done.append(_completed(gait, system, start, cycles, unilateral, bounds))
        found[float(size)] = tuple(done)
    return found


def _completed(
    gait: Gait, system: HybridSystem, start: Vector, cycles: int, unilateral: bool, bounds: ContactBounds
) -> int:
    if unilateral:
        return simulate(system, unilateral_start(gait, start), cycles, TOLERANCE, samples=2).cycles
    trace = simulate(system, start, cycles, TOLERANCE)
    return min(trace.cycles, _sound(gait, trace, bounds))


def _sound(gait: Gait, trace: Trace, bounds: ContactBounds) -> int:
    """Count the cycles before the first in which a foot pulls or leaves its cone."""
    report = contact_report(trace, gait.pattern, bounds)
    bad = np.flatnonzero(~((report.normal_forces > 0.0) & (report.frictions <= bounds.friction)))
    return int(bad[0]) if bad.size else trace.cycles
