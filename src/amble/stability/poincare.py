"""The Poincare map of a hybrid system: from the entry of its first domain to the next, and its differences.

The state after a reset lies on the section by itself, so the map needs no coordinates of a section: it takes any state
near an orbit, in all n coordinates, and returns a state just after a reset. Its derivative has the multipliers of the
orbit as eigenvalues, and one 0 more where the usual map on a section of dimension n - 1 has none.

The derivative by central differences of the whole map, with a sweep of the step, shares nothing with the variational
equations (``monodromy``) but the motion itself, so that their agreement means something. The stencil is the central one
of order 4: (8 (P(+h) - P(-h)) - (P(+2h) - P(-2h))) / 12 h. The error falls with h^4 until the noise of the integrator,
about its tolerance / h, takes over; the sweep goes from large steps to small ones and ends where the noise takes over
or nothing is left to gain.
"""

from __future__ import annotations

import functools
import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from amble.errors import FallError, InputError
from amble.hybrid import HybridSystem, Transition
from amble.hybrid.system import numeric
from amble.progress import Progress, ProgressReport
from amble.simulation.native_map import native_map
from amble.simulation.prepared import prepare, prepare_domain
from amble.simulation.walk import HybridArc, longest_step, walk
from amble.types import Matrix, NodeValues, Vector, frozen

TOLERANCE = 1e-12
TIME_LIMIT = 10.0

BESIDE = 1e-6
"""How far the state moves while it is seen where a guard goes, as a share of 1 + |x|."""

STEPS = (1e-3, 1e-4, 1e-5)
GOOD_ENOUGH = 1e-9
"""Relative distance of two neighbours in the sweep below which no smaller step is tried."""


def poincare_map(
    system: HybridSystem,
    state: Vector,
    tolerance: float = TOLERANCE,
    time_limit: float = TIME_LIMIT,
    cycles: int = 1,
    max_step: float | None = None,
) -> Vector:
    """Map the entry state of the first domain to the next one, one cycle later, or several.

    Args:
        system: the system.
        state: at the entry of the first domain, (n_x,).
        tolerance: of the integrator, relative and absolute.
        time_limit: the longest that one domain may last, s.
        cycles: how often the map is applied.
        max_step: the longest time between two event samples, s (``simulate``).

    Returns:
        The state at the entry of the first domain then, (n_x,).

    Raises:
        FallError: where the motion does not come back; the message says why and when.
        InputError: for a state of another size or that is not finite.
    """
    return _entered(walk(system, state, cycles, tolerance, 2, time_limit, max_step=max_step), cycles)


def _entered(motion: HybridArc, cycles: int) -> Vector:
    """Return the state at the entry of the first domain after some cycles, (n_x,)."""
    if motion.cycles < cycles:
        raise FallError(motion.ended)
    return motion.events[-1].after


def depends_on_clock(transition: Transition) -> bool:
    """Whether the guard of a transition may be moved by the clock alone."""
    try:
        return bool(transition.guard.jac_sparsity(0, 0).nnz())
    except RuntimeError:  # compiled without derivatives: nothing is known
        return True


def missing_dead_time(system: HybridSystem, state: Vector) -> str:
    """Name the guard of the first domain that needs a dead time; empty where none does.

    The guard of a section through a smooth cycle is zero at the entry and passes on in its direction. It does not fire
    there; but from a start that is moved back a little it would, and the return map of such starts is no map around the
    orbit.

    Args:
        system: the system.
        state: a state at the entry of the first domain, on the section, (n_x,).
    """
    domain = system.domains[0]
    rate = numeric(domain.field(0.0, state, domain.parameters))
    speed = float(np.linalg.norm(rate))
    ahead = BESIDE * (1.0 + float(np.linalg.norm(state))) / (speed if speed > 0.0 else 1.0)
    for transition in system.leaving(domain.name):
        here, there = (
            transition.direction * float(transition.guard(clock, state + clock * rate, domain.parameters))
            for clock in (0.0, ahead)
        )
        if transition.dead_time == 0.0 and abs(here) <= there - here:
            return (
                f"the guard of '{transition.name}' is zero at the entry of '{domain.name}' and about to fire, so from "
                "a start beside it it fires at once: give the transition a dead_time"
            )
    return ""


@dataclass(frozen=True)
class Differences:
    """dP/dx by differences.

    Attributes:
        matrix: the best of the sweep, (n_x, n_x).
        step: its step.
        disagreement: |best - its neighbour in the sweep| (2-norm): an estimate of the error of ``matrix``, no bound.
        sweep: (step, 2-norm distance to the matrix of the next step) for all steps taken but the last, less the first
            where one column shows that it is too large; infinite where a perturbed motion did not come back.
    """

    matrix: Matrix
    step: float
    disagreement: float
    sweep: tuple[tuple[float, float], ...]


def difference_check(
    system: HybridSystem,
    state: Vector,
    steps: Sequence[float] = STEPS,
    tolerance: float = TOLERANCE,
    time_limit: float = TIME_LIMIT,
    progress: Progress | None = None,
    cycles: int = 1,
    max_step: float | None = None,
) -> Differences:
    """Differentiate the Poincare map by central differences of order 4.

    Args:
        system: the system. A guard that is zero at the entry of the first domain needs ``Transition.dead_time``.
        state: where, (n_x,).
        steps: the sweep, at least two different steps; the same for every state. The smallest are not taken where
            larger ones agree well or the distances begin to grow.
        tolerance: of the integrator.
        time_limit: the longest that one domain may last, s.
        progress: called after every state.
        cycles: how often the map is applied.
        max_step: the longest time between two event samples, s (``simulate``).

    Raises:
        FallError: where the motion comes back for fewer than two neighbouring steps.
        InputError: for fewer than two steps, or steps that are not positive, and where a dead time is missing.
    """
    ordered = sorted(set(steps), reverse=True)
    if len(ordered) < 2 or ordered[-1] <= 0:
        raise InputError("the sweep of the differences takes at least two different positive steps")
    missing = missing_dead_time(system, np.array(state, dtype=np.float64).reshape(-1))
    if missing:
        raise InputError(missing)

    images = _images(system, tolerance, time_limit, cycles, max_step)

    @functools.cache
    def differences(step: float) -> Matrix | FallError:
        try:
            return _central(images, state, step, progress)
        except FallError as error:
            return error

    taken = ordered[1:] if _useless(differences, images, state, ordered) else ordered
    matrices, distances = _swept(differences, taken)
    best = int(np.argmin(distances))
    matrix = matrices[best + 1]
    if isinstance(matrix, FallError) or not np.isfinite(distances[best]):
        reason = next((str(found) for found in reversed(matrices) if isinstance(found, FallError)), "")
        raise FallError(f"no two steps of the difference sweep come back: {reason}")
    sweep = tuple(zip(taken, distances, strict=False))
    return Differences(frozen(matrix), taken[best + 1], distances[best], sweep)


def _swept(
    differences: Callable[[float], Matrix | FallError], steps: Sequence[float]
) -> tuple[list[Matrix | FallError], list[float]]:
    """Return the matrices of a sweep up to where it settles, and the distances of neighbours."""
    matrices, distances = list[Matrix | FallError](), list[float]()
    for step in steps:
        matrices.append(differences(step))
        distances.extend(_distance(*pair) for pair in itertools.pairwise(matrices[-2:]))
        if _settled(matrices[-1], distances):
            break
    return matrices, distances


def _useless(
    differences: Callable[[float], Matrix | FallError],
    images: Callable[[NodeValues], NodeValues],
    state: Vector,
    steps: Sequence[float],
) -> bool:
    """Whether the sweep comes to the same without its first step, as one column of that shows: a third of the walks.

    The column is a lower bound of the distance of the first two matrices. Where the next distance is below it the first
    step is not chosen, and the sweep neither ends with it nor because distances grow.
    """
    second = differences(steps[1])
    if len(steps) < 3 or isinstance(second, FallError):
        return False
    place = int(np.argmax(np.linalg.norm(second, axis=0)))
    try:
        column = _column(images, state, steps[0], np.eye(state.size)[place])
    except FallError:
        return False
    apart = float(np.linalg.norm(column - second[:, place]))
    return apart > GOOD_ENOUGH * float(np.linalg.norm(second, 2)) and _distance(second, differences(steps[2])) <= apart


def _settled(newest: Matrix | FallError, distances: Sequence[float]) -> bool:
    """Whether the sweep has come to its end: agreement, or distances that grow."""
    if isinstance(newest, FallError) or not distances:
        return False
    grows = len(distances) > 1 and distances[-2] < distances[-1] < np.inf
    return grows or distances[-1] <= GOOD_ENOUGH * float(np.linalg.norm(newest, 2))


def _images(
    system: HybridSystem, tolerance: float, time_limit: float, cycles: int, max_step: float | None
) -> Callable[[NodeValues], NodeValues]:
    """Return the map of several starts, (k, n_x), in native code where that can be had."""
    longest = longest_step(time_limit, max_step)
    prepared = {
        domain.name: (prepare_domain(system, domain.name), prepare(system, domain.name)) for domain in system.domains
    }
    native = native_map(system, prepared)

    def walked(start: Vector) -> Vector:
        motion = walk(system, start, cycles, tolerance, 2, time_limit, max_step=max_step, prepared=prepared)
        return _entered(motion, cycles)

    def images(starts: NodeValues) -> NodeValues:
        if native is None:
            return np.array([walked(start) for start in starts])
        found, returned = native(starts, tolerance, time_limit, longest, cycles)
        for row in np.flatnonzero(~returned):
            found[row] = walked(starts[row])
        return found

    return images


def _central(
    images: Callable[[NodeValues], NodeValues], state: Vector, step: float, progress: Progress | None
) -> Matrix:
    columns: list[Vector] = []
    for direction in np.eye(state.size):
        columns.append(_column(images, state, step, direction))
        if progress is not None:
            what = f"differences, step {step:g}, state"
            progress(ProgressReport(what=what, done=len(columns), of=state.size))
    return np.column_stack(columns)


def _column(images: Callable[[NodeValues], NodeValues], state: Vector, step: float, direction: Vector) -> Vector:
    ahead, behind, far_ahead, far_behind = images(state + step * np.outer((1.0, -1.0, 2.0, -2.0), direction))
    return np.asarray((8 * (ahead - behind) - (far_ahead - far_behind)) / (12 * step))


def _distance(first: Matrix | FallError, second: Matrix | FallError) -> float:
    if isinstance(first, FallError) or isinstance(second, FallError):
        return float("inf")
    return float(np.linalg.norm(first - second, 2))
