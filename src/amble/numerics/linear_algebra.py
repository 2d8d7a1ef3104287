"""Factorisations written as expressions, so that they compile into straight-line code without search or heap."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

SMALLEST = 1e-300
"""Stands for zero in a divisor."""


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
class OrthogonalFactor:
    """A Q = [L 0] of an expression with at most as many rows as columns, by Householder reflections.

    Backward stable without pivoting, sparse where A is. The smallest pivot bounds the smallest singular value from
    above, so it tells when rank is lost (Golub and Van Loan, Matrix Computations, section 5.2).

    Attributes:
        lower: L, (m, m).
        reflections: (normal, scale) of I - scale normal normal^T, whose product is Q.
        columns: n.
    """

    lower: ca.SX
    reflections: tuple[tuple[ca.SX, ca.SX], ...]
    columns: int

    @classmethod
    def of(cls, matrix: ca.SX) -> OrthogonalFactor:
        """Factor a matrix, (m, n) with m <= n."""
        m, n = matrix.shape
        work = ca.SX(matrix.T)
        reflections = []
        for k in range(min(m, n - 1)):
            column = ca.densify(work[k, k])
            length = ca.sqrt(ca.sumsqr(work[k:, k]))
            sign = ca.if_else(column >= 0, 1.0, -1.0)
            normal = ca.vertcat(ca.SX(k, 1), column + sign * length, work[k + 1 :, k])
            # a column of zeros is left alone: its pivot is zero, and the others stay numbers
            scale = 1.0 / ca.fmax(length * (length + sign * column), SMALLEST)
            work = ca.horzcat(work[:, :k], _reflected(work[:, k:], normal, scale))
            work[k + 1 :, k] = 0
            reflections.append((normal, scale))
        return cls(ca.sparsify(work[:m, :]).T, tuple(reflections), n)

    @property
    def pivots(self) -> ca.SX:
        """|L_ii|, (m,)."""
        return ca.fabs(ca.densify(ca.diag(self.lower)))

    @property
    def sines(self) -> ca.SX:
        """Sine of the angle between every row of A and those before it, (m,): pivots without units."""
        lengths = ca.sqrt(ca.sum2(self.lower**2))
        return self.pivots / ca.fmax(ca.densify(lengths), SMALLEST)

    @property
    def kernel(self) -> ca.SX:
        """Orthonormal basis of the x with A x = 0, (n, n - m)."""
        return self._turned(ca.SX.eye(self.columns)[:, self.lower.shape[0] :])

    def solve(self, right: ca.SX) -> ca.SX:
        """Return the shortest x with A x = right, one column a system."""
        m = self.lower.shape[0]
        z = ca.SX(0, right.shape[1])
        for k in range(m):
            z = ca.vertcat(z, (right[k, :] - self.lower[k, :k] @ z) / self.lower[k, k])
        return self._turned(ca.vertcat(z, ca.SX(self.columns - m, right.shape[1])))

    def _turned(self, vectors: ca.SX) -> ca.SX:
        """Q vectors."""
        for normal, scale in reversed(self.reflections):
            vectors = _reflected(vectors, normal, scale)
        return vectors


def _reflected(vectors: ca.SX, normal: ca.SX, scale: ca.SX) -> ca.SX:
    return vectors - (scale * normal) @ (normal.T @ vectors)
