"""The symmetry group of a hybrid system: its action on states, and how far a cycle moves along it.

A walker that repeats its step somewhere else is periodic up to the group: P(x) = g x with g = exp(sum_i s_i xi_i),
where xi_i are the generators of ``HybridSystem.symmetries`` (a translation of x: the constant unit vector of x). The
generators must span a Lie algebra, as translations do, or translations of x and y together with a turn about z.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.errors import InputError, WorkError
from amble.hybrid import Domain, HybridSystem, Invariant
from amble.hybrid.system import numeric
from amble.hybrid.validation import FIELD_ARGUMENTS
from amble.simulation.flow import TOO_LONG, FlowDefinition
from amble.simulation.prepared import prepare_flow
from amble.stability.monodromy import augmented
from amble.types import Matrix, Vector, frozen

TOLERANCE = 1e-13
CONVERGED = 1e-12
ITERATIONS = 50


@dataclass(frozen=True)
class Shift:
    """The group element that carries a state closest to another one.

    Attributes:
        amounts: s_i, one a symmetry.
        image: g x, (n_x,).
        matrix: d(g x)/dx, (n_x, n_x).
        slopes: d(g x)/ds, (n_x, n_symmetries).
    """

    amounts: Vector
    image: Vector
    matrix: Matrix
    slopes: Matrix


def generators(system: HybridSystem, state: Vector) -> Matrix:
    """Return the generators at a state as columns, (n_x, n_symmetries).

    Raises:
        InputError: where they are linearly dependent there.
    """
    columns = [numeric(symmetry.generator(state)) for symmetry in system.symmetries]
    matrix = np.array(columns).reshape(len(columns), system.state_size).T
    if np.linalg.matrix_rank(matrix) < len(columns):
        raise InputError(f"the symmetries {', '.join(s.name for s in system.symmetries)} are dependent at this state")
    return matrix


def gradients(system: HybridSystem, state: Vector) -> Matrix:
    """Return the gradients of the invariants at a state as columns, (n_x, n_invariants).

    Raises:
        InputError: where an invariant cannot be differentiated, or they are dependent there (at rest, at an extreme).
    """
    columns = [_gradient(invariant, state) for invariant in system.invariants]
    matrix = np.array(columns).reshape(len(columns), system.state_size).T
    if np.linalg.matrix_rank(matrix) < len(columns):
        raise InputError(f"the invariants {', '.join(i.name for i in system.invariants)} are dependent at this state")
    return matrix


def _gradient(invariant: Invariant, state: Vector) -> Vector:
    called = invariant.function
    names, result = called.name_in(), called.name_out()[0]
    try:
        slope = called.factory(f"{called.name()}_slope", names, [f"jac:{result}:{names[0]}"])
    except RuntimeError as error:
        raise InputError(f"invariant '{invariant.name}' has no derivatives") from error
    return numeric(slope(state))


def act(system: HybridSystem, amounts: Vector, state: Vector) -> Shift:
    """Move a state by exp(sum_i s_i xi_i), the flow of the generators for a unit of time, with s carried as a state."""
    size, count = system.state_size, len(system.symmetries)
    if not count:
        return Shift(frozen([]), frozen(state), frozen(np.eye(size)), frozen(np.zeros((size, 0))))
    if all(symmetry.generator.jac_sparsity(0, 0).nnz() == 0 for symmetry in system.symmetries):
        return _translated(system, amounts, state)
    clock, both, parameters = ca.MX.sym("t"), ca.MX.sym("z", size + count), ca.MX.sym("p", 0)
    weighted = [both[size + i] * symmetry.generator(both[:size]) for i, symmetry in enumerate(system.symmetries)]
    rate = ca.vertcat(ca.densify(sum(weighted, start=ca.MX.zeros(size))), ca.DM.zeros(count))
    field = ca.Function("symmetry", [clock, both, parameters], [rate], FIELD_ARGUMENTS, ["rate"])
    flow = prepare_flow(FlowDefinition(augmented(Domain(name="symmetry", field=field)), frozen([])))
    start = np.concatenate([state, amounts, np.eye(size + count).reshape(-1)])
    passed = flow(start, TOLERANCE, 1.0, 2, 1.0)
    if passed.ended != TOO_LONG:
        raise WorkError(f"the motion along the symmetries {passed.ended}")
    image, carried = np.split(passed.state[-1], [size + count])
    slopes = carried.reshape(size + count, size + count, order="F")[:size]
    return Shift(frozen(amounts), frozen(image[:size]), frozen(slopes[:, :size]), frozen(slopes[:, size:]))


def _translated(system: HybridSystem, amounts: Vector, state: Vector) -> Shift:
    """Generators that do not depend on the state are translations, whose flow is a sum."""
    columns = np.array([numeric(symmetry.generator(state)) for symmetry in system.symmetries]).T
    return Shift(frozen(amounts), frozen(state + columns @ amounts), frozen(np.eye(state.size)), frozen(columns))


def closest_shift(system: HybridSystem, state: Vector, target: Vector) -> Shift:
    """Find the group element that brings a state closest to a target (Gauss-Newton on the amounts).

    Raises:
        WorkError: where the amounts do not converge.
    """
    shift = act(system, np.zeros(len(system.symmetries)), state)
    if not system.symmetries:
        return shift
    for _ in range(ITERATIONS):
        change = np.linalg.lstsq(shift.slopes, target - shift.image, rcond=None)[0]
        if np.abs(change).max() <= CONVERGED * (1.0 + np.abs(shift.amounts).max()):
            return shift
        shift = act(system, shift.amounts + change, state)
    raise WorkError(f"no group element of the symmetries was found in {ITERATIONS} iterations")
