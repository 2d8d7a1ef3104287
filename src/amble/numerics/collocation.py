"""Collocation schemes as data that check themselves."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.errors import InputError
from amble.types import Matrix, Vector, frozen


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
