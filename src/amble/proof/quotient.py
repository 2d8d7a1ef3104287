"""The return map's derivative on the quotient by the symmetries: its contraction and its eigenvalues, proved.

A system that is invariant under translations Xi has D Xi = Xi S; what is stable or not is the block A of D on the
quotient (docs/theory/proof.md, section 5). At a fixed point the same holds of (Xi, eta), eta the generator of a turn.
"""

from __future__ import annotations

import warnings
from collections.abc import Sequence

import numpy as np
import scipy.linalg
from flint import acb, acb_mat, arb, arb_mat

from amble.errors import InputError
from amble.hybrid import HybridSystem
from amble.proof.arithmetic import exact_matrix, identity, largest, midpoints, symmetric
from amble.proof.errors import ProofError
from amble.stability.group import generators
from amble.types import Matrix, Vector

NEARER = 0.25
RATE_MARGINS = (1e-6, 1e-5, 1e-4, 1e-3, 2e-3, 1e-2, 0.05)
"""Shares of the distance to 1 by which the proved rate may lie above the estimate of the spectral radius."""

LARGE = 0.62
"""Share of the largest entry from which an entry of an eigenvector is large; walkers have ratios of 1/2 and of 1."""


def translations(system: HybridSystem, state: Vector) -> Matrix:
    """Return the symmetries of a system as columns, (n_x, n_symmetries).

    Raises:
        InputError: one of them is no translation, or they take every state to every other.
    """
    for symmetry in system.symmetries:
        if symmetry.generator.jac_sparsity(0, 0).nnz():
            raise InputError(f"symmetry '{symmetry.name}' is no translation: no proof modulo it; leave it out")
    if system.invariants:
        raise InputError("a system with conserved quantities has families of orbits: no proof of one")
    found = generators(system, state)
    if found.shape[1] == system.state_size:
        raise InputError("the symmetries translate every state: nothing is left of which stability could be proved")
    return found


def quotient(derivative: arb_mat, along: Matrix, turns: Sequence[Sequence[arb]] = ()) -> arb_mat:
    """Return the block of the derivative on the quotient by the symmetries.

    With T = (Xi, eta, U) invertible, D (Xi, eta) = (Xi, eta) S, so T^-1 D T is block triangular with the quotient's
    block last. Of Xi that is proved of the expressions (``invariance``), of eta of what a law writes (``turns``); the
    block of zeros is enclosed too, and has to hold them.

    Args:
        derivative: D.
        along: Xi.
        turns: generators of other symmetries at the fixed point, eta.

    Raises:
        ProofError: the derivative is proved to take a symmetry out of their span.
    """
    neutral = along.shape[1] + len(turns)
    middle = [[float(value.mid()) for value in turn] for turn in turns]
    span, full = complement(np.column_stack([along, *middle]))
    columns = exact_matrix(full).tolist()
    for row, values in zip(columns, zip(*turns, strict=True), strict=False):
        row[along.shape[1] : neutral] = values
    basis = arb_mat(columns)
    moved = basis.inv() * derivative
    if any(not value.contains(0) for row in (moved * basis).tolist()[neutral:] for value in row[:neutral]):
        raise ProofError("what is declared as a symmetry is none: the return map's derivative takes it to no symmetry")
    return arb_mat((moved * exact_matrix(span)).tolist()[neutral:])


def contracts(matrix: arb_mat, weight: Matrix, rate: float) -> bool:
    """Whether r^2 W - A^T W A > 0 and W > 0 for every matrix in the balls.

    With T of an approximate factorisation W = T^T T + E and S close to T^-1 the first is so exactly where

        r^2 S^T W S - (T A S)^T (T A S) - (A S)^T E (A S)

    is positive definite: this is close to r^2 - (T A S)^T (T A S), well conditioned though W is not.
    """
    factors = factored(weight)
    return factors is not None and contracts_along(matrix * factors[1], weight, rate)


def contracts_along(moved: arb_mat, weight: Matrix, rate: float) -> bool:
    """Whether the same holds for every matrix A S in the balls, S of ``factored``: sharper where that was enclosed."""
    factors, w = factored(weight), exact_matrix(weight)
    if factors is None:
        return False
    upper, inverse = factors
    turned = upper * moved
    rest = moved.transpose() * (w - upper.transpose() * upper) * moved
    kept = inverse.transpose() * w * inverse
    return _positive_definite(arb(rate) ** 2 * kept - turned.transpose() * turned - rest)


def factored(weight: Matrix) -> tuple[arb_mat, arb_mat] | None:
    """Return T with W = T^T T up to rounding and S close to T^-1, exact; None where W may be singular."""
    factor = _factor(exact_matrix(weight))
    return None if factor is None else (factor.mid(), factor.mid().inv().mid())


def holds_ball(inverse: arb_mat, weight: Matrix, wider: float) -> bool:
    """Whether every S y with |S y|_W <= 1 has |y| <= wider: wider^2 S^T W S - 1 is positive definite."""
    kept = inverse.transpose() * exact_matrix(weight) * inverse
    return _positive_definite(arb(wider) ** 2 * kept - identity(kept.nrows()))


def complement(along: Matrix) -> tuple[Matrix, Matrix]:
    """Return U, columns that complete the translations, and (Xi, U)."""
    if not along.shape[1]:
        return np.eye(along.shape[0]), np.eye(along.shape[0])
    factor, _ = np.linalg.qr(along, mode="complete")
    span = factor[:, along.shape[1] :]
    return span, np.hstack([along, span])


def contraction(matrix: arb_mat) -> tuple[Matrix, float]:
    """Return W and the smallest rate r that a factorisation proves; a rate of 2 where none below 1 is.

    W is that of a rate nearer to the spectral radius than r, so that r^2 W - A^T W A is a share of W.
    """
    middle = midpoints(matrix)
    estimate = float(np.abs(np.linalg.eigvals(middle)).max())
    for margin in RATE_MARGINS:
        rate, nearer = (estimate + share * margin * (1.0 - estimate) for share in (1.0, NEARER))
        if not 0.0 < rate < 1.0:
            break
        weight = lyapunov(middle, nearer)
        if contracts(matrix, weight, rate):
            return weight, rate
    return np.eye(len(middle)), 2.0


def lyapunov(matrix: Matrix, rate: float) -> Matrix:
    """Return W with W - (A/r)^T W (A/r) = 1, symmetric."""
    with warnings.catch_warnings():  # close to rate 1 it is ill-conditioned; what is proved with it is another matter
        warnings.simplefilter("ignore", scipy.linalg.LinAlgWarning)
        weight = scipy.linalg.solve_discrete_lyapunov((matrix / rate).T, np.eye(len(matrix)))
    return np.asarray(0.5 * (weight + weight.T))


def claimed(matrix: arb_mat, weight: Matrix, rate: float | None) -> tuple[Matrix, float]:
    """Check W and r that a proof claims."""
    if rate is None:
        return weight, 2.0
    if not (0.0 < rate < 1.0 and np.array_equal(weight, weight.T) and contracts(matrix, weight, rate)):
        raise ProofError(f"the claimed bound {rate:.6g} of the spectral radius does not follow with the claimed W")
    return weight, rate


def _positive_definite(matrix: arb_mat) -> bool:
    """Whether every symmetric matrix in the balls is positive definite.

    It is where the symmetric part of the midpoints, less the largest sum of a row's or column's radii, is: what a
    symmetric matrix can differ from that part has no larger norm.
    """
    radii = [[value.rad() for value in row] for row in matrix.tolist()]
    slack = largest(sum(line, start=arb(0)) for lines in (radii, zip(*radii, strict=True)) for line in lines)
    exact = matrix.mid()
    return _factor((exact + exact.transpose()) / 2 - identity(matrix.nrows()) * slack) is not None


def _factor(matrix: arb_mat) -> arb_mat | None:
    """Return T with matrix = T^T T, upper triangular; None where a pivot is not proved to be positive."""
    size, rows = matrix.nrows(), matrix.tolist()
    factor = [[arb(0)] * size for _ in range(size)]
    for k in range(size):
        if not rows[k][k] > 0:
            return None
        root = rows[k][k].sqrt()
        factor[k][k:] = [value / root for value in rows[k][k:]]
        for i in range(k + 1, size):
            for j in range(i, size):
                rows[i][j] = rows[i][j] - factor[k][i] * factor[k][j]
    return arb_mat(factor)


def gershgorin(matrix: arb_mat) -> list[tuple[acb, bool]]:
    """Return discs that together hold the eigenvalues, each with whether it holds exactly one, alone.

    With T of approximate eigenvectors the discs of T^-1 A T are small (Gershgorin's theorem); one that meets no other
    holds exactly one eigenvalue. Empty where T cannot be inverted.
    """
    try:
        # at the working precision: what floating point misses of T widens the discs of eigenvalues that are close
        basis = _scaled(acb_mat(matrix.mid()).eig(right=True, algorithm="approx")[1].mid())
        turned = (basis.inv() * acb_mat(matrix) * basis).tolist()
    except (ZeroDivisionError, ValueError):
        return []
    balls = []
    for i, row in enumerate(turned):
        reach = sum((value.abs_upper() for j, value in enumerate(row) if j != i), start=arb(0))
        balls.append(row[i] + acb(symmetric(reach), symmetric(reach)))
    return [
        (ball, not any(ball.overlaps(other) for j, other in enumerate(balls) if j != i)) for i, ball in enumerate(balls)
    ]


def _scaled(vectors: acb_mat) -> acb_mat:
    """Scale every column so that one of its large entries is 1: discs depend on it, and are those of any precision.

    The first entry that is nearly as large as the largest: which is the larger of two of one size rounding would say.
    """
    scaled = []
    for column in zip(*vectors.tolist(), strict=True):
        sizes = [float(abs(value).mid()) for value in column]
        pivot = next(value for value, size in zip(column, sizes, strict=True) if size >= LARGE * max(sizes))
        scaled.append([(value / pivot).mid() for value in column])
    return acb_mat(scaled).transpose()
