"""Fixed points of the Poincare map by Newton, up to the symmetries of the system.

Shorthand of this file: P the Poincare map, x the state, g = exp(sum_i s_i xi_i) the group element that brings x closest
to P(x), Xi the generators as columns, r = P(x) - g x. A Newton step solves

    (DP - Dg) dx - dg/ds ds = -r,      Xi(x)^T dx = 0,                                                          (1)

whose second row pins the state along the symmetries: every point of the group orbit is a solution.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from amble.errors import FallError, NotSolvedError
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport
from amble.residual import Residual
from amble.stability.group import Shift, closest_shift, generators
from amble.stability.monodromy import Monodromy, Variational, prepare_variational
from amble.stability.poincare import TIME_LIMIT, TOLERANCE
from amble.types import Vector, frozen

SMALLEST_SHARE = 2.0**-10
DECREASE = 1e-4


@dataclass(frozen=True)
class FixedPoint:
    """A state that a cycle reproduces, up to the symmetries.

    Attributes:
        state: at the entry of the first domain, (n_x,).
        shift: how far a cycle moves along each symmetry, by name.
        residual: largest |P(x) - g x|.
        history: residuals of the Newton iterates, the first that of the guess.
        monodromy: the map and its derivative there.
    """

    state: Vector
    shift: dict[str, float]
    residual: float
    history: tuple[float, ...]
    monodromy: Monodromy

    @property
    def period(self) -> float:
        """Duration of a cycle, s."""
        return self.monodromy.period


@dataclass(frozen=True)
class _Iterate:
    state: Vector
    map: Monodromy
    shift: Shift

    @property
    def residual(self) -> Vector:
        return self.map.image - self.shift.image

    @property
    def size(self) -> float:
        return float(np.abs(self.residual).max())


def fixed_point(
    system: HybridSystem,
    guess: Vector,
    accuracy: float = 1e-10,
    tolerance: float = TOLERANCE,
    time_limit: float = TIME_LIMIT,
    iterations: int = 30,
    progress: Progress | None = None,
) -> FixedPoint:
    """Find a fixed point of the Poincare map by damped Newton with the monodromy matrix.

    Args:
        system: the system.
        guess: state at the entry of the first domain, (n_x,); along the symmetries the solution keeps its values.
        accuracy: largest |P(x) - g x| that counts as solved; one step more is taken then, and kept if it is better.
        tolerance: of the integrator.
        time_limit: the longest that one domain may last, s.
        iterations: the most Newton steps.
        progress: called after every step.

    Raises:
        FallError: where the motion from the guess does not come back.
        NotSolvedError: where Newton stops above the accuracy; the rows are the components of the residual.
    """
    variational = prepare_variational(system)

    def evaluate(state: Vector) -> _Iterate:
        return _evaluate(system, variational, state, tolerance, time_limit)

    current = evaluate(np.array(guess, dtype=np.float64).reshape(-1))
    history = [current.size]
    status = f"{iterations} Newton steps were not enough"
    for number in range(1, iterations + 1):
        solved = current.size <= accuracy
        trial = _damped(evaluate, current, _newton_step(system, current), full=solved)
        if trial is not None and (not solved or trial.size < current.size):
            current = trial
            history.append(current.size)
            if progress is not None:
                progress(ProgressReport(what="fixed point, step", done=number, quantity="residual", value=current.size))
        if solved:
            return _result(system, current, tuple(history))
        if trial is None:
            status = "no Newton step reduces the residual"
            break
    if current.size <= accuracy:
        return _result(system, current, tuple(history))
    raise NotSolvedError(
        f"{status} (residual {current.size:.3g} after {len(history) - 1} steps)", _rows(system, current)
    )


def _evaluate(
    system: HybridSystem, variational: Variational, state: Vector, tolerance: float, time_limit: float
) -> _Iterate:
    there = variational(state, tolerance, time_limit)
    return _Iterate(state, there, closest_shift(system, state, there.image))


def _newton_step(system: HybridSystem, current: _Iterate) -> Vector:
    """Equation (1)."""
    along = generators(system, current.state)
    pins = along.shape[1]
    matrix = np.block(
        [[current.map.matrix - current.shift.matrix, -current.shift.slopes], [along.T, np.zeros((pins, pins))]]
    )
    right = np.concatenate([-current.residual, np.zeros(pins)])
    step = np.linalg.lstsq(matrix, right, rcond=None)[0]
    return np.asarray(step[: current.state.size])


def _damped(evaluate: Callable[[Vector], _Iterate], current: _Iterate, step: Vector, full: bool) -> _Iterate | None:
    """Halve the step until the motion comes back and the residual falls; None where no share of it does."""
    share = 1.0
    while share >= (1.0 if full else SMALLEST_SHARE):
        try:
            trial = evaluate(current.state + share * step)
        except FallError:
            trial = None
        if trial is not None and trial.size < (1.0 - DECREASE * share) * current.size:
            return trial
        share *= 0.5
    return None


def _result(system: HybridSystem, current: _Iterate, history: tuple[float, ...]) -> FixedPoint:
    names = [symmetry.name for symmetry in system.symmetries]
    shift = dict(zip(names, map(float, current.shift.amounts), strict=True))
    return FixedPoint(frozen(current.state), shift, current.size, history, current.map)


def _rows(system: HybridSystem, current: _Iterate) -> list[Residual]:
    return [
        Residual(f"P(x) - x of {name}", 0.0, float(value), 0.0)
        for name, value in zip(system.state_names, current.residual, strict=True)
    ]
