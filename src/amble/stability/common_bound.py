"""One quadratic Lyapunov function for several linear maps: V(x) = x^T W x that falls by r^2 under each of them.

Let L^T L = W. Then A^T W A < r^2 W says |L A L^-1| < r in the 2-norm, so the least r is that of the ellipsoidal norm in
which the largest of the maps is smallest. log |L A L^-1| is convex along geodesics of W (Ando and Shih, SIAM J. Matrix
Anal. Appl. 19, 1998, for this bound on the joint spectral radius), so a descent finds the least one; no semidefinite
program is needed. It begins at the mean-square equation

    W - (1 / m) sum_i A_i^T W A_i / s^2 = 1,                                                                    (1)

whose W already gives r <= sqrt(m) s. What is found is verified by Cholesky factors, apart from how it was found.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from amble.stability.lyapunov import QuadraticBound, verified_bound
from amble.types import Matrix, Vector, frozen

ROUNDS = (2, 8, 32, 128)
"""Exponents p in turn: the largest singular value is smoothed by the p-th moment of the squares of all."""

EVALUATIONS = 150
"""Of a round, at most."""

ABOVE_RADIUS = 0.02
"""Distance of s above the mean-square radius in (1), relative."""

TERMS, SETTLED = 1000, 1e-6

WIDEST = 1e15
"""Condition of a metric, at most: beyond it Cholesky factors lose their digits."""

SMALLEST = 1e-3
"""No smaller rate is looked for: where all long products vanish there is none, and the metrics grow without bound."""

ABOVE = (1e-9, 1e-7, 1e-5, 1e-3, 1e-2)
"""What the rate is above the largest norm found, relative: the least of these at which rounding leaves it verified."""


@dataclass(frozen=True)
class CommonBound:
    """W and r with r^2 W - A_i^T W A_i > 0 for every A_i.

    Attributes:
        rate: r; the bound says something where it is below 1.
        metric: W, (m, m), in the coordinates of the maps.
        bounds: the verdict on every map (``quadratic_bound.verified_bound``).
    """

    rate: float
    metric: Matrix
    bounds: tuple[QuadraticBound, ...]

    @property
    def verified(self) -> bool:
        """Whether W > 0 and every inequality are verified, whatever r is."""
        return min(min(bound.definite, bound.decrease) for bound in self.bounds) > 0.0


def common_bound(matrices: Sequence[Matrix]) -> CommonBound:
    """Find W > 0 and the least r for several matrices.

    Args:
        matrices: A_i, (m, m) each, finite.
    """
    maps = [np.asarray(matrix, dtype=np.float64) for matrix in matrices]
    if not any(matrix.any() for matrix in maps):
        return _judged(maps, 0.5, np.eye(len(maps[0])), np.ones(len(maps[0])))  # any rate will do
    scales = _balancing(maps)
    balanced = [matrix * scales / scales[:, None] for matrix in maps]
    for metric in _metrics(balanced):
        found = _bounded(balanced, metric, scales)
        if found.verified:
            break
    return found


def _metrics(balanced: Sequence[Matrix]) -> Iterator[Matrix]:
    """Metrics with Cholesky factors, best first; the last is 1, in which the rate is the largest norm."""
    for start in (_mean_square(balanced), np.eye(len(balanced[0]))):
        try:
            root = _descended(balanced, _root(start))
            metric = np.asarray(root.T @ root)
            _root(metric)
        except np.linalg.LinAlgError:
            continue
        yield metric
    yield np.eye(len(balanced[0]))


def _bounded(balanced: Sequence[Matrix], metric: Matrix, scales: Vector) -> CommonBound:
    """Return the least rate of a metric at which rounding leaves it verified; one that is not, where none is."""
    root = _root(metric)
    rate = max(float(np.linalg.norm(_seen(root, matrix), 2)) for matrix in balanced)
    for above in ABOVE:
        found = _judged(balanced, max(rate, SMALLEST) * (1.0 + above), metric, scales)
        if found.verified:
            break
    return found


def _judged(balanced: Sequence[Matrix], rate: float, metric: Matrix, scales: Vector) -> CommonBound:
    """Verify W in balanced coordinates; the scales are powers of two, so that the inequalities are the same."""
    bounds = tuple(verified_bound(matrix, rate, metric) for matrix in balanced)
    return CommonBound(rate, frozen(metric / np.outer(scales, scales)), bounds)


def _root(metric: Matrix) -> Matrix:
    """L with L^T L = W."""
    return np.asarray(np.linalg.cholesky(metric).T)


def _seen(root: Matrix, matrix: Matrix) -> Matrix:
    """L A L^-1."""
    return np.asarray(np.linalg.solve(root.T, (root @ matrix).T).T)


def _balancing(maps: Sequence[Matrix]) -> Vector:
    """Powers of two that balance the maps together."""
    from scipy.linalg import matrix_balance

    _, (scales, _) = matrix_balance(np.sum(np.abs(maps), axis=0), permute=False, separate=True)
    return np.asarray(scales)


def _mean_square(maps: Sequence[Matrix]) -> Matrix:
    """W of (1), by its sum, for s a little above the mean-square radius."""
    stacked = np.array(maps)

    def carried(metric: Matrix) -> Matrix:
        image: Matrix = np.einsum("kia,ij,kjb->ab", stacked, metric, stacked, optimize=True) / len(stacked)
        return 0.5 * (image + image.T)

    direction, square = np.eye(len(stacked[0])), 0.0
    for _ in range(TERMS):  # the cone of metrics is kept, so powers of the sum find its largest eigenvalue
        image = carried(direction)
        before, square = square, float(np.trace(image) / np.trace(direction))
        if square == 0.0 or abs(square - before) <= SETTLED * square:
            break
        direction = image / np.trace(image)
    square = max(square * (1.0 + ABOVE_RADIUS) ** 2, SMALLEST**2)
    metric = term = np.eye(len(direction))
    for _ in range(TERMS):
        term = carried(term) / square
        metric = metric + term
        if not np.trace(metric) < WIDEST:  # maps that magnify long before they shrink: no start
            return np.eye(len(direction))
        if np.trace(term) <= SETTLED * np.trace(metric):
            break
    return metric / np.trace(metric)


def _descended(maps: Sequence[Matrix], start: Matrix) -> Matrix:
    """Descend from L to one with a smaller largest |L A L^-1|; round by round the moment becomes the largest value."""
    from scipy.optimize import minimize

    size, root = len(start), start
    for exponent in ROUNDS:
        seen = [_seen(root, matrix) for matrix in maps]

        def objective(flat: Vector, seen: Sequence[Matrix] = seen, exponent: int = exponent) -> tuple[float, Vector]:
            value, pull, _ = smoothed_norm(flat.reshape(size, size), seen, exponent)
            return value, pull.ravel()

        options = {"maxfun": EVALUATIONS, "maxiter": EVALUATIONS, "maxcor": 30}
        found = minimize(objective, np.eye(size).ravel(), jac=True, method="L-BFGS-B", options=options)
        root = np.linalg.qr(found.x.reshape(size, size) @ root)[1]
    return np.asarray(root)


def smoothed_norm(root: Matrix, maps: Sequence[Matrix], exponent: int) -> tuple[float, Matrix, list[Matrix]]:
    """Logarithm of the moment of all singular values of B_i = L A_i L^-1, no less than that of the largest norm.

    With S_i its slope in B_i, that in A_i is L^T S_i L^-T, and that in L is sum_i (S_i B_i^T - B_i^T S_i) L^-T, since
    dB_i = X B_i - B_i X with X = dL L^-1.

    Args:
        root: L, (m, m), with an inverse.
        maps: A_i, (m, m) each.
        exponent: p; the moment comes to the largest value as it grows.

    Returns:
        It, its slope in L, (m, m), and its slopes in A_i, (m, m) each.
    """
    seen = [_seen(root, matrix) for matrix in maps]
    parts = [np.linalg.svd(matrix) for matrix in seen]
    largest = max(float(values[0]) for _, values, _ in parts)
    if largest <= SMALLEST:
        return float(np.log(SMALLEST)), np.zeros_like(root), [np.zeros_like(root) for _ in maps]
    powers = [(values / largest) ** (2 * exponent) for _, values, _ in parts]
    total = float(np.sum(powers))
    pull, slopes = np.zeros_like(root), list[Matrix]()
    for matrix, (left, values, right), power in zip(seen, parts, powers, strict=True):
        inverse = np.divide(power, values, out=np.zeros_like(power), where=values > 0.0)
        slope = (left * (inverse / total)) @ right
        pull += slope @ matrix.T - matrix.T @ slope
        slopes.append(root.T @ np.linalg.solve(root, slope.T).T)
    value = float(np.log(largest) + np.log(total) / (2 * exponent))
    return value, np.asarray(np.linalg.solve(root, pull.T).T), slopes
