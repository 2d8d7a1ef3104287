"""Quadratic Lyapunov functions of linear maps, and the smoothed spectral radius that they define.

For a matrix A (m, m) and s above its spectral radius rho let

    W(s) - (A / s)^T W(s) (A / s) = 1,   so   W(s) = sum_k (A^k / s^k)^T (A^k / s^k).                              (1)

Its trace, sum_k |A^k / s^k|_F^2, falls from infinity at rho to m at infinity; the root s of trace W(s) = c is the
smoothed spectral radius (Vanbiervliet, Vandereycken, Michiels, Vandewalle, Diehl, SIAM J. Optim. 20, 2009):
differentiable in A where rho is not, above rho, and falling to it as c grows. V(x) = x^T W x falls by
the factor s^2 under A, and 1 <= W <= c, so that

    |A^k| <= sqrt(c) s^k:                                                                                          (2)

c is the price of transient growth.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.errors import InputError
from amble.types import Matrix

DOUBLINGS = 60
"""Terms of (1) up to k = 2^60: whatever converges in floating point at all."""

DIVERGED = 1e30
ROOT_TOLERANCE = 1e-12
ROUNDING = 1e-9


@dataclass(frozen=True)
class SmoothedRadius:
    """The smoothed spectral radius of a matrix.

    Attributes:
        value: s.
        metric: W of (1), (m, m).
        slope: d log s / d A, (m, m).
    """

    value: float
    metric: Matrix
    slope: Matrix


def smoothed_radius(matrix: Matrix, trace: float) -> SmoothedRadius:
    """Return the root s of trace W(s) = c, with W and the exact slope of log s.

    With P - (A / s) P (A / s)^T = 1 (of the same trace), d trace W / d A = 2 W A P / s^2 and
    d trace W / d s = -2 <W A P, A> / s^3, so that d log s / d A = W A P / <W A P, A>.

    Args:
        matrix: A, not zero.
        trace: c, above the size of A.

    Raises:
        InputError: A is zero or not finite, or c is not above its size.
    """
    from scipy.optimize import brentq

    size, frobenius = len(matrix), float(np.linalg.norm(matrix))
    if not 0.0 < frobenius < np.inf:
        raise InputError("the smoothed spectral radius is that of a finite matrix which is not zero")
    if not size < trace < np.inf:
        raise InputError(f"the trace is {trace:g}; it must be above {size}, the size of the matrix")
    # trace W >= 1 / (1 - (rho / s)^2) and >= m + |A|_F^2 / s^2, and <= m / (1 - (|A|_2 / s)^2): both ends of the root
    radius = float(np.abs(np.linalg.eigvals(matrix)).max())
    low = max(radius / np.sqrt(1.0 - 1.0 / trace), frobenius / np.sqrt(trace - size))
    high = float(np.linalg.norm(matrix, 2)) / np.sqrt(1.0 - size / trace)

    def short(trial: float) -> float:  # 1 / trace is nearly linear at the radius, and zero where the sum diverges
        return 1.0 / trace - 1.0 / float(np.trace(accumulated(matrix / trial)))

    give = ROUNDING  # eigenvalues of a matrix far from normal have an error; the lower end gives way by more
    while short(low) <= 0.0:
        low *= 1.0 - give
        give *= 4.0
    found = float(brentq(short, low, high * (1.0 + ROUNDING), xtol=low * ROOT_TOLERANCE, rtol=ROOT_TOLERANCE))
    metric, dual = accumulated(matrix / found), accumulated(matrix.T / found)
    pull = metric @ matrix @ dual
    return SmoothedRadius(found, metric, pull / float(np.sum(pull * matrix)))


def accumulated(matrix: Matrix) -> Matrix:
    """Sum (B^k)^T B^k over all k, the solution W of W - B^T W B = 1, by doubling (Smith, SIAM J. Appl. Math. 16, 1968).

    A direct solution would lose the positive definite W where B is far from normal. All entries are infinite where the
    sum exceeds 1e30, as it does where it diverges.
    """
    weight, power = np.eye(len(matrix)), matrix
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(DOUBLINGS):
            term = power.T @ weight @ power
            weight = weight + term
            largest = np.abs(weight).max()
            if not np.abs(term).max() > np.finfo(np.float64).eps * largest or not largest < DIVERGED:
                break
            power = power @ power
    if not largest < DIVERGED:
        return np.full_like(weight, np.inf)
    return np.asarray(0.5 * (weight + weight.T))
