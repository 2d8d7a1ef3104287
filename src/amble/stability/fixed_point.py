"""Fixed points of the Poincare map by Newton, up to the symmetries of the system, at given values of its invariants.

Shorthand of this file: P the Poincare map (or its n-th iterate), x the state, g = exp(sum_i s_i xi_i) the group element
that brings x closest to P(x), Xi the generators as columns, r = P(x) - g x, I the invariants with I_0 their values at
the guess. A Newton step solves

    (DP - Dg) dx - dg/ds ds + grad I a = -r,      Xi(x)^T dx = 0,      grad I(x)^T dx = I_0 - I(x).             (1)

The second row pins the state along the symmetries: every point of the group orbit is a solution. The third keeps the
values of the invariants; the a are 0 in the end, and make up for the equations that the invariants take away
(Munoz-Almaraz, Freire, Galan, Doedel and Vanderbauwhede 2003). A family of fixed points that nothing declares shows as
directions in which (1) does not change; the step has no part along them, so that the guess is not moved along the
family, and their number is reported.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from amble.amounts import check_amount
from amble.errors import NotSolvedError, WorkError
from amble.hybrid import HybridSystem
from amble.hybrid.system import numeric
from amble.progress import Progress, ProgressReport, silent
from amble.residual import Residual
from amble.stability.group import Shift, closest_shift, generators, gradients
from amble.stability.monodromy import Monodromy, prepare_variational
from amble.stability.period import least_cycles, other_period
from amble.stability.poincare import TIME_LIMIT, TOLERANCE, depends_on_clock, missing_dead_time
from amble.types import Vector, frozen

MOST_ITERATIONS = 10_000

SMALLEST_SHARE = 2.0**-10
DECREASE = 1e-4

NEUTRAL = 1e-9
"""Singular values of (1) below this share of the largest are those of a family: the derivative's own error is there."""

STILL = 10.0
"""A motion that would come this many times the accuracy far in its period, at its speed at the entry, stands still."""

SHRUNK = 1e-3
"""A cycle that lasts this share of the guess's is on its way to nothing."""


@dataclass(frozen=True, kw_only=True)
class FixedPoint:
    """A state that a cycle reproduces, up to the symmetries.

    Attributes:
        state: at the entry of the first domain, (n_x,).
        shift: how far a cycle moves along each symmetry, by name.
        residual: largest |P(x) - g x|.
        history: residuals of the Newton iterates, the first that of the guess.
        monodromy: the map and its derivative there.
        cycles: after which the state returns; of a map of several cycles perhaps a part of them.
        family: directions in which the fixed point can be moved without ceasing to be one, beside the symmetries and
            at the same values of the invariants; 0 where it is isolated.
    """

    state: Vector
    shift: dict[str, float]
    residual: float
    history: tuple[float, ...]
    monodromy: Monodromy
    cycles: int = 1
    family: int = 0

    @property
    def period(self) -> float:
        """Duration of a cycle, or of all cycles of the map, s."""
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
    cycles: int = 1,
    max_step: float | None = None,
    enough: float = 0.0,
) -> FixedPoint:
    """Find a fixed point of the Poincare map by damped Newton with the monodromy matrix.

    Args:
        system: the system.
        guess: state at the entry of the first domain, (n_x,); the solution keeps its place along symmetries and any
            undeclared family, and the values of invariants.
        accuracy: largest |P(x) - g x| that counts as solved; one step more is taken then, and kept if it is better.
        tolerance: of the integrator.
        time_limit: the longest that one domain may last, s.
        iterations: the most Newton steps, from 1 to 10,000.
        progress: called after every step.
        cycles: after which the orbit closes.
        max_step: the longest time between two event samples, s (``simulate``).
        enough: residual that counts as solved where no Newton step reduces it, as beside a multiplier of nearly 1.

    Raises:
        FallError, WorkError: where the motion from the guess does not come back, or only grazes a guard.
        InputError: where numbers are out of range, symmetries or invariants dependent, or functions not differentiable.
        NotSolvedError: Newton stops above the accuracy, or left a guess of another period; its rows are the residual's.
    """
    check_amount("iterations", iterations, 1, MOST_ITERATIONS)
    variational = prepare_variational(system)
    start = np.array(guess, dtype=np.float64).reshape(-1)

    def evaluate(state: Vector) -> _Iterate:
        there = variational(state, tolerance, time_limit, cycles, max_step)
        return _Iterate(state, there, closest_shift(system, state, there.image))

    current = first = evaluate(start)
    values, history, notify = _values(system, start), [current.size], progress or silent
    status = f"{iterations} Newton steps were not enough"
    for number in range(1, iterations + 1):
        solved = current.size <= accuracy
        trial = _damped(evaluate, current, _newton_step(system, current, values)[0], full=solved)
        if trial is not None and (not solved or trial.size < current.size):
            current = trial
            history.append(current.size)
            notify(ProgressReport(what="fixed point, step", done=number, quantity="residual", value=current.size))
        if solved or trial is None:
            status = "no Newton step reduces the residual"
            break
    if current.size <= accuracy or (trial is None and current.size <= enough):
        status = _no_orbit(system, current, evaluate, accuracy) or other_period(
            system, start, current.state, current.map.matrix, cycles, time_limit, max_step
        )
    if status:
        raise _not_found(system, status, first, current, len(history) - 1)
    return _result(system, current, values, tuple(history), accuracy)


def _not_found(system: HybridSystem, status: str, first: _Iterate, last: _Iterate, steps: int) -> NotSolvedError:
    reasons = "; ".join(filter(None, [status, *_reasons(system, first, last)]))
    rows = [
        Residual(f"P(x) - x of {name}", 0.0, float(value), 0.0)
        for name, value in zip(system.state_names, last.residual, strict=True)
    ]
    return NotSolvedError(f"{reasons} (residual {last.size:.3g} after {steps} steps)", rows)


def _newton_step(system: HybridSystem, current: _Iterate, values: Vector) -> tuple[Vector, int]:
    """Solve equation (1); returns dx and the number of directions in which (1) does not change."""
    along, kept = generators(system, current.state), gradients(system, current.state)
    pins, invariants = along.shape[1], kept.shape[1]
    rows = np.column_stack([along, kept]).T
    matrix = np.block(
        [
            [current.map.matrix - current.shift.matrix, -current.shift.slopes, kept],
            [rows, np.zeros((pins + invariants, pins + invariants))],
        ]
    )
    missed = values - _values(system, current.state)
    right = np.concatenate([-current.residual, np.zeros(pins), missed])
    step, _, rank, _ = np.linalg.lstsq(matrix, right, rcond=NEUTRAL)
    return np.asarray(step[: current.state.size]), int(matrix.shape[0] - rank)


def _values(system: HybridSystem, state: Vector) -> Vector:
    return np.array([float(invariant.function(state)) for invariant in system.invariants])


def _no_orbit(system: HybridSystem, current: _Iterate, evaluate: Callable[[Vector], _Iterate], accuracy: float) -> str:
    """Say that a fixed point is no orbit because its motion stands still or ends at once; empty where it is one."""
    domain, period = system.domains[0], current.map.period
    clocks = (0.0, 0.3 * period, 0.7 * period)  # a field may begin to move later
    rates = [numeric(domain.field(clock, current.state, domain.parameters)) for clock in clocks]
    if np.abs(rates).max() * period <= STILL * accuracy and not any(
        depends_on_clock(item) for item in system.leaving(domain.name)
    ):
        return "Newton came to an equilibrium of the field, where no motion crosses a guard"
    if not missing_dead_time(system, current.map.image):
        return ""
    around = evaluate(current.map.image)
    return "the motion ends where it begins" if period < 0.5 * around.map.period else ""


def _reasons(system: HybridSystem, first: _Iterate, last: _Iterate) -> list[str]:
    """What may be the reason that there is no solution."""
    missing = missing_dead_time(system, last.map.image)
    shrunk = last.map.period < SHRUNK * first.map.period
    short = f"the cycle shrinks to nothing (to {last.map.period:.2g} s): its events accumulate" if shrunk else ""
    return [reason for reason in (missing, short) if reason]


def _damped(evaluate: Callable[[Vector], _Iterate], current: _Iterate, step: Vector, full: bool) -> _Iterate | None:
    """Halve the step until the motion comes back, does not graze, and the residual falls; None where no share does."""
    share = 1.0
    while share >= (1.0 if full else SMALLEST_SHARE):
        try:
            trial = evaluate(current.state + share * step)
        except WorkError:
            trial = None
        if trial is not None and trial.size < (1.0 - DECREASE * share) * current.size:
            return trial
        share *= 0.5
    return None


def _result(
    system: HybridSystem, current: _Iterate, values: Vector, history: tuple[float, ...], accuracy: float
) -> FixedPoint:
    names = [symmetry.name for symmetry in system.symmetries]
    return FixedPoint(
        state=frozen(current.state),
        shift=dict(zip(names, map(float, current.shift.amounts), strict=True)),
        residual=current.size,
        history=history,
        monodromy=current.map,
        cycles=least_cycles(system, current.state, current.map.entries, accuracy),
        family=_newton_step(system, current, values)[1],
    )
