"""How fast a simulated motion approaches its orbit: the measured counterpart of the spectral radius.

The leading multiplier is measured with starts moved along its mode, by how fast that mode decays.

With A V = V B and L^T A = B L^T for the multipliers nearest to the leading one, the coordinates L^T dx of a small
deviation are multiplied by B in every cycle, whatever the other modes do; of a deviation as such only the slowest
mode's decay is left after many cycles, when it has sunk into the integrator's error. Multipliers that nearly meet are
measured together: of each one alone the mode is ill-conditioned (three within 2e-3 of a stabilised trot have the
condition 4e7), so that a simulation shows anything; the product of their moduli, |det B|, is well-conditioned.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.errors import FallError, InputError
from amble.hybrid import HybridSystem
from amble.simulation import simulate
from amble.stability.group import closest_shift
from amble.stability.poincare import TIME_LIMIT
from amble.stability.spectrum import Spectrum
from amble.types import Matrix, NodeValues, Vector, frozen

FEWEST = 4

SIZE, SMALLEST = 1e-5, 1e-9
"""The start's distance from the orbit, and how small the mode may become; the integrator's error is far below that."""

NEAR = 0.1
"""Multipliers closer than this share of the radius, in the complex plane, are measured together."""

CYCLES = 3
TOLERANCE = 1e-12


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


@dataclass(frozen=True)
class LeadingMode:
    """A measured contraction.

    Attributes:
        rate: factor by which the leading modes shrink in a simulated cycle, geometric mean over modes and cycles.
        predicted: geometric mean of the moduli of their multipliers; the spectral radius where it is one, or a pair.
        cycles: simulated times around the orbit, fewer where the modes decay fast.
        modes: how many multipliers are measured together.
    """

    rate: float
    predicted: float
    cycles: int
    modes: int = 1

    @property
    def difference(self) -> float:
        """Relative difference of the two."""
        return abs(self.rate - self.predicted) / self.predicted


def leading_mode(
    system: HybridSystem,
    state: Vector,
    spectrum: Spectrum,
    cycles: int = 1,
    time_limit: float = TIME_LIMIT,
    max_step: float | None = None,
) -> LeadingMode | None:
    """Simulate starts moved along the leading modes and measure their decay; None where a cycle leaves too little.

    Args:
        system: the system.
        state: the fixed point, (n_x,).
        spectrum: of the Poincare map there.
        cycles: of the orbit.
        time_limit: the longest that one domain may last, s.
        max_step: the longest time between two event samples, s (``simulate``).

    Raises:
        FallError: the motion does not come back.
    """
    turns = min(CYCLES, _visible(spectrum.radius))
    if not turns:
        return None

    def passed(change: Vector) -> NodeValues:
        """Deviations from the fixed point at the start and at the end, modulo the symmetries, (2, n_x)."""
        trace = simulate(
            system, state + change, turns * cycles, TOLERANCE, samples=2, time_limit=time_limit, max_step=max_step
        )
        if not trace.completed:
            raise FallError(trace.ended)
        ends = (trace.section[0], trace.section[-1])
        return np.array([row - closest_shift(system, state, row).image for row in ends])

    right, left, block = leading_subspace(spectrum)
    columns = []
    for direction in right.T:
        # up less down: what is quadratic in the start cancels
        ends = [passed(sign * SIZE * spectrum.basis @ direction) for sign in (1.0, -1.0)]
        before, after = (ends[0] - ends[1]) @ spectrum.basis @ left
        columns.append((before, after))
    begun, ended = np.array(columns).transpose(1, 2, 0)
    power = 1.0 / (turns * len(block))
    return LeadingMode(
        rate=float(abs(np.linalg.det(ended) / np.linalg.det(begun)) ** power),
        predicted=float(abs(np.linalg.det(block)) ** (1.0 / len(block))),
        cycles=turns,
        modes=len(block),
    )


def leading_subspace(spectrum: Spectrum) -> tuple[Matrix, Matrix, Matrix]:
    """Return V, L and B with A V = V B, L^T A = B L^T and L^T V = 1 of the multipliers nearest to the leading one.

    Returns:
        V and L, (m, k), and B, (k, k).
    """
    from scipy.linalg import schur, solve_sylvester

    values = np.linalg.eigvals(spectrum.matrix).astype(np.complex128)
    inside = _near_leading(values)
    members, others = values[inside], values[~inside]

    def selected(real: float, imaginary: float) -> bool:
        value = complex(real, imaginary)
        return bool(np.abs(members - value).min() < np.abs(others - value).min(initial=np.inf))

    upper, rotation, count = schur(spectrum.matrix, sort=selected)
    block, rest, coupling = upper[:count, :count], upper[count:, count:], upper[:count, count:]
    beside = solve_sylvester(block, -rest, coupling) if len(rest) else coupling  # [1 X] T = B [1 X]
    return rotation[:, :count], rotation @ np.vstack([np.eye(count), beside.T]), block


def _near_leading(values: NDArray[np.complex128]) -> NDArray[np.bool_]:
    """Which multipliers hang together with the leading one by steps of at most ``NEAR`` radii; conjugates included."""
    reach = NEAR * float(np.abs(values).max())
    inside = np.abs(values) == np.abs(values).max()
    while True:
        members = np.concatenate([values[inside], values[inside].conj()])
        grown = np.abs(values[:, np.newaxis] - members).min(axis=1) <= reach
        if np.array_equal(grown, inside):
            return grown
        inside = grown


def _visible(radius: float) -> int:
    """After how many cycles the mode is still to be seen; as many as wanted where it does not decay."""
    if radius >= 1.0:
        return CYCLES
    return int(np.log(SMALLEST / SIZE) / np.log(radius)) if radius > 0.0 else 0
