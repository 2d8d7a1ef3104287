"""The leading multiplier measured in simulation: a start moved along its mode, and how fast that mode decays.

With A w_r = lambda w_r and w_l^H A = lambda w_l^H, the coordinate w_l^H dx of a small deviation is multiplied by lambda
in every cycle, whatever the other modes do; of a deviation as such only the slowest mode's decay is left after many
cycles, when it has sunk into the integrator's error.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.errors import FallError
from amble.hybrid import HybridSystem
from amble.simulation import simulate
from amble.stability.group import closest_shift
from amble.stability.poincare import TIME_LIMIT
from amble.stability.spectrum import Spectrum
from amble.types import Vector

SIZE, SMALLEST = 1e-5, 1e-9
"""The start's distance from the orbit, and how small the mode may become; the integrator's error is far below that."""

CYCLES = 3
TOLERANCE = 1e-12


@dataclass(frozen=True)
class LeadingMode:
    """A measured contraction.

    Attributes:
        rate: factor by which the leading mode shrinks in a simulated cycle, geometric mean.
        predicted: the spectral radius.
        cycles: simulated times around the orbit, fewer where the mode decays fast.
    """

    rate: float
    predicted: float
    cycles: int

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
    """Simulate a start moved along the leading mode and measure its decay; None where a cycle leaves too little of it.

    Args:
        system: the system.
        state: the fixed point, (n_x,).
        spectrum: of the Poincare map there.
        cycles: of the orbit.
        time_limit: the longest that one domain may last, s.
        max_step: the longest time between two looks at the guards, s (``simulate``).

    Raises:
        FallError: the motion does not come back.
    """
    from scipy.linalg import eig

    turns = min(CYCLES, _visible(spectrum.radius))
    if not turns:
        return None
    values, lefts, rights = eig(spectrum.matrix, left=True)
    leading = int(np.argmax(np.abs(values)))
    left = lefts[:, leading].conj()
    direction = np.real(rights[:, leading])
    start = state + SIZE * spectrum.basis @ (direction / np.linalg.norm(direction))
    trace = simulate(system, start, turns * cycles, TOLERANCE, samples=2, time_limit=time_limit, max_step=max_step)
    if not trace.completed:
        raise FallError(trace.ended)
    deviations = [row - closest_shift(system, state, row).image for row in trace.section[::cycles]]
    sizes = [abs(left @ (spectrum.basis.T @ deviation)) for deviation in deviations]
    rate = float((sizes[-1] / sizes[0]) ** (1.0 / turns))
    return LeadingMode(rate, float(np.abs(values[leading])), turns)


def _visible(radius: float) -> int:
    """After how many cycles the mode is still to be seen; as many as wanted where it does not decay."""
    if radius >= 1.0:
        return CYCLES
    return int(np.log(SMALLEST / SIZE) / np.log(radius)) if radius > 0.0 else 0
