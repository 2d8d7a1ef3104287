"""Runge-Kutta schemes as data that check themselves: collocation schemes, and DOP853 of the simulation."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from amble.errors import InputError, WorkError
from amble.types import Matrix, Vector, frozen

STAGES = 12
EXTENDED = 16
ROUNDOFF = 1e-13


@dataclass(frozen=True)
class CollocationScheme:
    """An implicit Runge-Kutta scheme whose first node is the start and whose last node is the end of the interval.

    At the nodes, x_i = x_0 + h sum_j integration[i, j] x'_j: the polynomial through the rates is integrated exactly.

    Attributes:
        name: the scheme's name.
        nodes: position of the nodes in the unit interval, (s,).
        integration: Butcher matrix, (s, s); its first row is zero.
        order: order of convergence of the end point.
    """

    name: str
    nodes: Vector
    integration: Matrix
    order: int

    def __post_init__(self) -> None:
        """Check the collocation conditions sum_j a_ij c_j^(k-1) = c_i^k / k and the quadrature order (Butcher)."""
        c, a = self.nodes, self.integration
        if c[0] != 0.0 or c[-1] != 1.0 or a.shape != (c.size, c.size):
            raise InputError(f"collocation scheme '{self.name}' does not span the unit interval")
        for k in range(1, c.size + 1):
            if not np.allclose(a @ c ** (k - 1), c**k / k, rtol=0.0, atol=1e-14):
                raise InputError(f"collocation scheme '{self.name}' is not exact for degree {k - 1}")
        for k in range(1, self.order + 1):
            if not np.isclose(self.weights @ c ** (k - 1), 1.0 / k, rtol=0.0, atol=1e-14):
                raise InputError(f"the weights of collocation scheme '{self.name}' are not of order {self.order}")

    @property
    def weights(self) -> Vector:
        """Quadrature weights over the unit interval, (s,)."""
        return self.integration[-1]


HERMITE_SIMPSON = CollocationScheme(
    "hermite-simpson",
    frozen([0.0, 0.5, 1.0]),
    frozen([[0.0, 0.0, 0.0], [5 / 24, 8 / 24, -1 / 24], [1 / 6, 4 / 6, 1 / 6]]),
    4,
)
"""Hermite-Simpson in its separated form, which is Lobatto IIIA with three nodes (Hargraves and Paris, 1987)."""


def node_positions(scheme: CollocationScheme, intervals: int) -> Vector:
    """Return the positions in [0, 1] of all nodes of equal intervals, shared ends once, (intervals (s-1) + 1,)."""
    inner = scheme.nodes[1:]
    steps = np.arange(intervals)[:, None]
    return frozen(np.concatenate([[0.0], ((steps + inner) / intervals).ravel()]))


def node_weights(scheme: CollocationScheme, intervals: int) -> Vector:
    """Return quadrature weights over [0, 1] for ``node_positions``; they sum to one."""
    weights = np.zeros(intervals * (scheme.nodes.size - 1) + 1)
    stride = scheme.nodes.size - 1
    for interval in range(intervals):
        weights[interval * stride : (interval + 1) * stride + 1] += scheme.weights / intervals
    return frozen(weights)


@dataclass(frozen=True)
class Tableau:
    """Coefficients of the method.

    Attributes:
        a: row s holds the weights of stage s, (16, 16): rows 0 to 11 the step, row 12 its solution, 13 to 15 the
            stages that only the dense output needs.
        c: clocks of the stages as a share of the step, (16,).
        error3: weights of the error estimate of order 3, (13,).
        error5: weights of the error estimate of order 5, (13,).
        dense: weights of the four higher coefficients of the dense output, (4, 16).
    """

    a: Matrix
    c: Vector
    error3: Vector
    error5: Vector
    dense: Matrix

    def __post_init__(self) -> None:
        """Check the row sums, the quadrature conditions to order 8 and that the error estimates vanish on constants."""
        weights = self.a[STAGES, :STAGES]
        sums = [
            np.abs(self.a.sum(axis=1) - self.c).max(),
            *(abs(weights @ self.c[:STAGES] ** (k - 1) - 1.0 / k) for k in range(1, 9)),
            abs(self.error3.sum()),
            abs(self.error5.sum()),
            np.abs(np.triu(self.a)).max(),
        ]
        if not max(sums) < ROUNDOFF:
            raise WorkError(f"the coefficients of the integrator do not fit together (defect {max(sums):.1e})")


@functools.cache
def dop853() -> Tableau:
    """Return the coefficients of DOP853.

    Raises:
        WorkError: where the coefficients do not pass their own check.
    """
    from scipy.integrate import DOP853

    a, c = np.zeros((EXTENDED, EXTENDED)), np.zeros(EXTENDED)
    a[:STAGES, :STAGES] = DOP853.A[:STAGES, :STAGES]
    a[STAGES, :STAGES] = DOP853.B
    a[STAGES + 1 :] = DOP853.A_EXTRA
    c[:STAGES], c[STAGES], c[STAGES + 1 :] = DOP853.C[:STAGES], 1.0, DOP853.C_EXTRA
    return Tableau(frozen(a), frozen(c), frozen(DOP853.E3), frozen(DOP853.E5), frozen(DOP853.D))
