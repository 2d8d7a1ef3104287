"""A verified bound on how fast an orbit attracts: V(x) = x^T W x falls by the factor r^2 in every cycle.

W > 0 and r^2 W - A^T W A > 0 are the matrix inequalities of the paper's stabilisation with W known. They are verified
apart from the equation that gave W: a Cholesky factor L of M - d 1 with the residual R = L L^T - (M - d 1) shows that
no eigenvalue of the symmetric M is below d - |R|; what rounding leaves uncertain in M and R is taken off.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from amble.residual import Residual
from amble.stability.lyapunov import accumulated, smoothed_radius
from amble.types import Json, Matrix, frozen

TRACE = 1e4
"""Trace of W in balanced coordinates, unless a radius near 1 needs more: a larger one is sharper and promises less
about the first cycles."""

ROUNDING = float(np.finfo(np.float64).eps)


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
    return _balanced_bound(matrix, np.where(np.abs(matrix) > ROUNDING * np.abs(matrix).max(), matrix, 0.0))


def _balanced_bound(matrix: Matrix, shape: Matrix) -> QuadraticBound:
    """Find the bound of a matrix in coordinates that balance another one."""
    from scipy.linalg import matrix_balance

    _, (scales, _) = matrix_balance(shape, permute=False, separate=True)
    balanced = matrix * scales / scales[:, None]
    trace = max(TRACE, 2.0 * float(np.trace(accumulated(balanced))))  # at s = 1 the trace is below it, so r < 1
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
    error = 2.0 * (size + 2) * ROUNDING * float(np.linalg.norm(products))
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
    rounding = (len(matrix) + 2) * ROUNDING * float(np.linalg.norm(products))
    return shift - float(np.linalg.norm(factor @ factor.T - shifted)) - rounding
