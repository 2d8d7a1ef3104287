"""How fast a simulated motion approaches its orbit: the measured counterpart of the spectral radius."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.errors import InputError
from amble.hybrid import HybridSystem
from amble.stability.group import closest_shift
from amble.types import NodeValues, Vector, frozen

FEWEST = 4


@dataclass(frozen=True)
class Contraction:
    """A fit of distance ~ rate^cycle.

    Attributes:
        rate: factor by which the distance shrinks in a cycle.
        error: standard error of the rate, from the scatter about the fit.
        first: first cycle that was used.
        last: last cycle that was used.
    """

    rate: float
    error: float
    first: int
    last: int


def section_distances(system: HybridSystem, section: NodeValues, state: Vector) -> Vector:
    """Return the distance of section states to a fixed point, modulo the symmetries, (n_cycles + 1,).

    Args:
        system: the system.
        section: states at the entries of the first domain (``Trace.section``), (n_cycles + 1, n_x).
        state: the fixed point, (n_x,).
    """
    return frozen([np.linalg.norm(row - closest_shift(system, state, row).image) for row in section])


def contraction(distances: Vector, floor: float = 1e-8, skip: float = 1.0 / 3.0) -> Contraction:
    """Measure the contraction of a motion by regression of log distance on the cycle.

    Used are the cycles before the distance first falls to ``floor`` (below it the error of the integrator shows),
    without the first share ``skip`` of them (there the fast modes still decay).

    Args:
        distances: to the fixed point, one a cycle from the start, (n,).
        floor: distance below which nothing is concluded.
        skip: share of the cycles that is left out at the beginning.

    Raises:
        InputError: where fewer than 4 cycles remain.
    """
    values = np.asarray(distances, dtype=np.float64)
    low = np.flatnonzero(values <= floor)
    stop = int(low[0]) if low.size else values.size
    first = int(np.ceil(skip * stop))
    if stop - first < FEWEST:
        raise InputError(f"the contraction needs {FEWEST} cycles above {floor:g}; there are {max(stop - first, 0)}")
    cycles = np.arange(first, stop, dtype=np.float64)
    design = np.column_stack([np.ones_like(cycles), cycles])
    logs = np.log(values[first:stop])
    coefficients = np.linalg.lstsq(design, logs, rcond=None)[0]
    scatter = logs - design @ coefficients
    spread = np.sqrt(scatter @ scatter / (len(cycles) - 2) / np.sum((cycles - cycles.mean()) ** 2))
    rate = float(np.exp(coefficients[1]))
    return Contraction(rate, float(rate * spread), first, stop - 1)
