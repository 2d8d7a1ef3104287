"""The derivative of the return map at a fixed point two ways, and the error bar of its spectral radius.

By variational equations, over a sweep of the integrator's tolerance, and by differences of the whole map. The error bar
is rho_e(A) - rho(A), where rho_e is the pseudospectral radius: the largest radius that any perturbation of size e of A
can give, with e the distance of the two matrices plus the change of A under the last step of the sweep, in coordinates
that suit A (``pseudospectrum``). It is an estimate: e is measured, not proven.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport
from amble.stability.monodromy import Monodromy, prepare_variational
from amble.stability.poincare import TIME_LIMIT, Differences, difference_check
from amble.stability.spectrum import Spectrum, largest_radius, spectrum
from amble.types import Vector


@dataclass(frozen=True, kw_only=True)
class TwoWays:
    """The derivative at a state.

    Attributes:
        monodromy: by variational equations, at the tightest tolerance.
        spectrum: of that, modulo the symmetries.
        error: error bar of the spectral radius, an estimate.
        disagreement: distance of the two matrices A (2-norm), relative to the first where that is above 1: against 1 is
            a return map judged, and of a superstable orbit it is nearly 0.
        sweep: (tolerance of the integrator, spectral radius).
        differences: the second opinion.
    """

    monodromy: Monodromy
    spectrum: Spectrum
    error: float
    disagreement: float
    sweep: tuple[tuple[float, float], ...]
    differences: Differences


def differentiate(
    system: HybridSystem,
    state: Vector,
    tolerances: Sequence[float],
    notify: Progress,
    time_limit: float = TIME_LIMIT,
    cycles: int = 1,
    max_step: float | None = None,
) -> TwoWays:
    """Differentiate the return map at a fixed point; arguments and errors are those of ``certify``."""
    variational = prepare_variational(system)
    swept = []
    for tolerance in sorted(set(tolerances), reverse=True):
        notify(ProgressReport(what=f"variational equations, tolerance {tolerance:g}"))
        there = variational(state, tolerance, time_limit, cycles, max_step)
        swept.append((tolerance, there, spectrum(system, state, there.image, there.matrix)))
    _, there, best = swept[-1]
    differences = difference_check(
        system, state, time_limit=time_limit, progress=notify, cycles=cycles, max_step=max_step
    )
    second = spectrum(system, state, there.image, differences.matrix)
    previous = swept[max(len(swept) - 2, 0)][2]
    doubts = (best.matrix - second.matrix, best.matrix - previous.matrix)
    return TwoWays(
        monodromy=there,
        spectrum=best,
        error=largest_radius(best.matrix, doubts) - best.radius,
        disagreement=float(np.linalg.norm(doubts[0], 2)) / max(float(np.linalg.norm(best.matrix, 2)), 1.0),
        sweep=tuple((tolerance, candidate.radius) for tolerance, _, candidate in swept),
        differences=differences,
    )
