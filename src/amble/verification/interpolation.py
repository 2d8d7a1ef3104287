"""The motion between the nodes: Hermite curves through the recorded positions, velocities and accelerations."""

from __future__ import annotations

from math import comb

import numpy as np

from amble.amounts import check_amount
from amble.gait.record import DomainTrajectory
from amble.numerics.collocation import HERMITE_SIMPSON, hermite
from amble.types import Matrix, Vector

FINEST = 1000
"""Most points of a node spacing: a motion of some hundred nodes still fits into memory, and nothing is left to see."""


def fine_grid(times: Vector, grid: int) -> Vector:
    """Return the nodes and ``grid - 1`` points evenly between every two of them.

    Raises:
        InputError: the grid is not from 1 to ``FINEST``.
    """
    check_amount("points in every spacing of nodes", grid, 1, FINEST)
    steps = np.arange(grid) / grid
    inner = times[:-1, None] + np.diff(times)[:, None] * steps
    return np.append(inner.ravel(), times[-1])


def interpolated(domain: DomainTrajectory, at: Vector) -> tuple[Matrix, Matrix]:
    """Return q and v at clocks inside the domain, (points, n_q) each.

    With three nodes an interval q follows the quintic that meets q, v, a at both nodes around, v the cubic that meets
    v, a. The slope of the quintic would be a poorer velocity: an interval's middle position is accurate to fourth order
    only, and a slope divides its error by the node spacing. With more nodes q follows the polynomial that meets q, v at
    all nodes of an interval, v that which meets v, a there (``hermite``).
    """
    t, q, v, a = domain.times, domain.positions, domain.velocities, domain.accelerations
    if domain.scheme != HERMITE_SIMPSON:
        name, T = domain.scheme, domain.duration
        return hermite(name, q, T * v, at / T), hermite(name, v, T * a, at / T)
    left = np.clip(np.searchsorted(t, at, side="right") - 1, 0, len(t) - 2)
    right = left + 1
    h = (t[right] - t[left])[:, None]
    s = (at - t[left])[:, None] / h
    position = _bezier(
        [
            q[left],
            q[left] + h * v[left] / 5.0,
            q[left] + 2.0 * h * v[left] / 5.0 + h**2 * a[left] / 20.0,
            q[right] - 2.0 * h * v[right] / 5.0 + h**2 * a[right] / 20.0,
            q[right] - h * v[right] / 5.0,
            q[right],
        ],
        s,
    )
    rate = _bezier([v[left], v[left] + h * a[left] / 3.0, v[right] - h * a[right] / 3.0, v[right]], s)
    return position, rate


def _bezier(points: list[Matrix], s: Matrix) -> Matrix:
    """Bezier curve whose coefficients differ from place to place (Farin, Curves and Surfaces for CAGD, section 7.5)."""
    order = len(points) - 1
    return np.asarray(sum(comb(order, k) * s**k * (1.0 - s) ** (order - k) * p for k, p in enumerate(points)))
