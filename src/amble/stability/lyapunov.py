"""Quadratic Lyapunov functions of linear maps, and the smoothed spectral radius that they define.

For a matrix A (m, m) and s above its spectral radius rho let

    W(s) - (A / s)^T W(s) (A / s) = 1,   so   W(s) = sum_k (A^k / s^k)^T (A^k / s^k).                              (1)

Its trace, sum_k |A^k / s^k|_F^2, falls from infinity at rho to m at infinity; the root s of trace W(s) = c is the
smoothed spectral radius (Vanbiervliet, Vandereycken, Michiels, Vandewalle, Diehl, SIAM J. Optim. 20, 2009):
differentiable in A where rho is not, above rho, and falling to it as c grows. V(x) = x^T W x falls by
the factor s^2 under A, and 1 <= W <= c, so that

    |A^k| <= sqrt(c) s^k:                                                                                          (2)

c is the price of transient growth.

One of them bounds, verified, how fast an orbit attracts: V(x) = x^T W x falls by the factor r^2 in every cycle.

W > 0 and r^2 W - A^T W A > 0 are the matrix inequalities of the paper's stabilisation with W known. They are verified
apart from the equation that gave W: a Cholesky factor L of M - d 1 with the residual R = L L^T - (M - d 1) shows that
no eigenvalue of the symmetric M is below d - |R|; what rounding leaves uncertain in M and R is taken off.
"""

from __future__ import annotations

import ctypes
import functools
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from amble.codegen.c_file import numerical
from amble.errors import InputError
from amble.numerics.blas import addresses
from amble.residual import Residual
from amble.types import Json, Matrix, frozen

SOURCE = Path(__file__).with_suffix(".c")

DOUBLINGS = 60
"""Terms of (1) up to k = 2^60: whatever converges in floating point at all."""

DIVERGED = 1e30
ROOT_TOLERANCE, MOST_STEPS = 1e-12, 100
ROUNDING = 1e-9

BOUND_TRACE = 1e4
"""Trace of W in balanced coordinates, unless a radius near 1 needs more: a larger one is sharper and promises less
about the first cycles."""

EPSILON = float(np.finfo(np.float64).eps)


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
    size, frobenius = len(matrix), float(np.linalg.norm(matrix))
    if not 0.0 < frobenius < np.inf:
        raise InputError("the smoothed spectral radius is that of a finite matrix which is not zero")
    if not size < trace < np.inf:
        raise InputError(f"the trace is {trace:g}; it must be above {size}, the size of the matrix")
    # trace W >= 1 / (1 - (rho / s)^2) and >= m + |A|_F^2 / s^2, and <= m / (1 - (|A|_F / s)^2): both ends of the root
    radius = float(np.abs(np.linalg.eigvals(matrix)).max())
    low = max(radius / np.sqrt(1.0 - 1.0 / trace), frobenius / np.sqrt(trace - size))
    high = frobenius / np.sqrt(1.0 - size / trace)
    lower, upper, trial = 0.0, high * (1.0 + ROUNDING), float(low)
    for _ in range(MOST_STEPS):
        metric, dual = _accumulated_both(matrix / trial)
        step = _newton_step(metric, dual, trace)
        if abs(step) <= ROOT_TOLERANCE:
            break
        lower, upper = (trial, upper) if step > 0.0 else (lower, trial)
        ahead = trial * float(np.exp(step))
        trial = ahead if lower < ahead < upper else float(np.sqrt(max(lower, 0.25 * trial) * upper))
    pull = metric @ matrix @ dual
    return SmoothedRadius(trial, metric, pull / float(np.sum(pull * matrix)))


def _newton_step(metric: Matrix, dual: Matrix, trace: float) -> float:
    """Return by how much log s has to change for trace W = c; infinite where the sum (1) diverges.

    With <P, W> = sum_k (k + 1) |A^k / s^k|^2 the slope of log trace W in log s is -2 (<P, W> / trace W - 1). The
    logarithm is convex, so that from below its step falls short; near the radius 1 / trace is nearly linear in 1 / s^2,
    whose step is longer there.
    """
    size = float(np.trace(metric))
    if not np.isfinite(size):
        return float("inf")
    fall, missed = 2.0 * (float(np.sum(metric * dual)) / size - 1.0), size / trace
    shrunk = 1.0 - 2.0 * (missed - 1.0) / fall
    by_pole = -0.5 * float(np.log(shrunk)) if shrunk > 0.0 else float("inf")
    return max(by_pole, float(np.log(missed)) / fall) if missed > 1.0 else by_pole


def _accumulated_both(matrix: Matrix) -> tuple[Matrix, Matrix]:
    """Return W = sum_k (B^k)^T B^k and P = sum_k B^k (B^k)^T, as ``accumulated`` does; infinite where they diverge."""
    library = numerical(SOURCE)
    if library is None:
        return accumulated(matrix), accumulated(matrix.T)
    found, power = np.empty((4, *matrix.shape)), np.array(matrix, dtype=np.float64, order="F")
    metric, dual = found[:2]
    first, size = found.ctypes.data, power.nbytes
    places = (ctypes.c_void_p(first + k * size) for k in range(3))
    start = ctypes.c_void_p(power.ctypes.data)
    if not library.amble_accumulated(_gemm(), len(matrix), start, DOUBLINGS, ctypes.c_double(DIVERGED), *places):
        return np.full_like(metric, np.inf), np.full_like(metric, np.inf)
    return 0.5 * (metric + metric.T), 0.5 * (dual + dual.T)


@functools.cache
def _gemm() -> ctypes.c_void_p:
    return ctypes.c_void_p(*addresses({"cython_blas": ("dgemm",)}))


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


@dataclass(frozen=True)
class QuadraticBound:
    """W and r with r^2 W - A^T W A > 0.

    Attributes:
        rate: r, below 1.
        metric: W, (m, m), in the coordinates of A.
        definite: a lower bound of the least eigenvalue of W.
        decrease: a lower bound of the least eigenvalue of r^2 W - A^T W A; rounding is taken off in both. Of
            ``quadratic_bound`` both are those in balanced coordinates: the sign is the same, and states of very
            different size leave no digit of it otherwise.
    """

    rate: float
    metric: Matrix
    definite: float
    decrease: float

    def rows(self) -> tuple[Residual, ...]:
        """Return what must hold as rows."""
        least = float(np.nextafter(0.0, 1.0))
        return (
            Residual("contraction bound r", 0.0, self.rate, float(np.nextafter(1.0, 0.0))),
            Residual("least eigenvalue of W", least, self.definite, float("inf")),
            Residual("least eigenvalue of r^2 W - A^T W A", least, self.decrease, float("inf")),
        )

    def to_dict(self) -> Json:
        """Return the bound as a tree for a JSON file."""
        return {"rate": self.rate, "W": self.metric.tolist()}


def quadratic_bound(matrix: Matrix) -> QuadraticBound:
    """Return a bound below 1 for a matrix A whose spectral radius is.

    Args:
        matrix: A, with spectral radius below 1.
    """
    if not matrix.any():
        return verified_bound(matrix, 0.5, np.eye(len(matrix)))  # any rate will do
    found = _balanced_bound(matrix, matrix)
    if min(found.definite, found.decrease) > 0.0:
        return found
    # a row of roundoff alone is balanced by a scale without measure
    return _balanced_bound(matrix, np.where(np.abs(matrix) > EPSILON * np.abs(matrix).max(), matrix, 0.0))


def _balanced_bound(matrix: Matrix, shape: Matrix) -> QuadraticBound:
    """Find the bound of a matrix in coordinates that balance another one."""
    from scipy.linalg import matrix_balance

    _, (scales, _) = matrix_balance(shape, permute=False, separate=True)
    balanced = matrix * scales / scales[:, None]
    trace = max(BOUND_TRACE, 2.0 * float(np.trace(accumulated(balanced))))  # at s = 1 the trace is below it, so r < 1
    found = smoothed_radius(balanced, trace)
    # the scales are powers of two, so that this is the same inequality to the last bit, with less to cancel
    bound = verified_bound(balanced, found.value, found.metric)
    return replace(bound, metric=frozen(found.metric / np.outer(scales, scales)))


def verified_bound(matrix: Matrix, rate: float, metric: Matrix) -> QuadraticBound:
    """Judge any r and symmetric W for A, wherever they come from."""
    size = len(matrix)
    difference = rate**2 * metric - matrix.T @ metric @ matrix
    products = np.abs(rate**2 * metric) + np.abs(matrix).T @ np.abs(metric) @ np.abs(matrix)
    # a product of three matrices of size m has the relative error 2 (m + 2) eps of the product of their moduli
    error = 2.0 * (size + 2) * EPSILON * float(np.linalg.norm(products))
    definite = least_eigenvalue_bound(metric)
    return QuadraticBound(
        rate, frozen(metric), definite, least_eigenvalue_bound(0.5 * (difference + difference.T)) - error
    )


def least_eigenvalue_bound(matrix: Matrix) -> float:
    """Return a number that no eigenvalue of a symmetric matrix is below, verified by a Cholesky factor.

    Where the matrix is not positive definite the eigenvalue solver's own least eigenvalue is returned, not verified.
    """
    least = float(np.linalg.eigvalsh(matrix).min())
    shift = 0.5 * least
    shifted = matrix - shift * np.eye(len(matrix))
    try:
        factor = np.linalg.cholesky(shifted)
    except np.linalg.LinAlgError:
        return min(least, 0.0)
    if shift <= 0.0:
        return least
    products = np.abs(factor) @ np.abs(factor).T + np.abs(shifted)
    rounding = (len(matrix) + 2) * EPSILON * float(np.linalg.norm(products))
    return shift - float(np.linalg.norm(factor @ factor.T - shifted)) - rounding
