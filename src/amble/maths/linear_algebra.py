"""Factorisations written as expressions, so that they compile into straight-line code without search or heap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca


@dataclass(frozen=True)
class SymmetricFactor:
    """P A P^T = (L + I) D (L + I)^T of a symmetric positive definite expression, sparse where A is.

    Attributes:
        pivots: the diagonal D; all positive where A is positive definite.
        lower: the strict factor, transposed, as casadi keeps it.
        order: the permutation P.
    """

    pivots: ca.SX
    lower: ca.SX
    order: tuple[int, ...]

    @classmethod
    def of(cls, matrix: ca.SX, order: Sequence[int] | None = None) -> SymmetricFactor:
        """Factor a symmetric positive definite matrix, eliminating its rows in the given order."""
        chosen = list(range(matrix.shape[0])) if order is None else list(order)
        pivots, lower, _ = ca.ldl(matrix[chosen, chosen], False)
        return cls(pivots, lower, tuple(chosen))

    def solve(self, right: ca.SX) -> ca.SX:
        """Return A^-1 right, one column a system."""
        forward = list(self.order)
        backward = [forward.index(i) for i in range(len(forward))]
        columns = list(range(right.shape[1]))
        natural = list(range(len(forward)))
        return ca.ldl_solve(ca.densify(right)[forward, columns], self.pivots, self.lower, natural)[backward, columns]


@dataclass(frozen=True)
class SquareSolution:
    """The solution of a square system and the pivots |R_ii| met on the way."""

    value: ca.SX
    pivots: ca.SX


def solve_square(matrix: ca.SX, right: ca.SX) -> SquareSolution:
    """Solve a square system by Householder reflections: backward stable without pivoting.

    The smallest pivot bounds the smallest singular value from above, so it tells when rank is lost
    (Golub and Van Loan, Matrix Computations, section 5.2).

    Args:
        matrix: (n, n).
        right: (n, k).
    """
    n = matrix.shape[0]
    work = ca.densify(ca.horzcat(matrix, right))
    diagonal = []
    for k in range(n):
        column = work[k:, k]
        length = ca.sqrt(ca.sumsqr(column))
        if k == n - 1:
            diagonal.append(work[k, k])
            break
        sign = ca.if_else(column[0] >= 0, 1.0, -1.0)
        normal = ca.vertcat(column[0] + sign * length, column[1:])
        scale = 1.0 / (length * (length + sign * column[0]))
        rest = work[k:, k + 1 :]
        work[k:, k + 1 :] = rest - (scale * normal) @ (normal.T @ rest)
        diagonal.append(-sign * length)
    pivots = ca.vertcat(*diagonal)
    value = ca.SX(n, right.shape[1])
    for k in range(n - 1, -1, -1):
        known = work[k, k + 1 : n] @ value[k + 1 :, :] if k < n - 1 else 0.0
        value[k, :] = (work[k, n:] - known) / pivots[k]
    return SquareSolution(value, ca.fabs(pivots))
