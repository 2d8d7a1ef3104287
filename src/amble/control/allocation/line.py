"""Exact minima along a line, as straight-line code: what two stance feet need (docs/theory/allocation.md)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

import casadi as ca


@dataclass(frozen=True)
class Interval:
    """Numbers from ``lower`` to ``upper``; empty where lower > upper, and then ``nearest`` stands for it."""

    lower: ca.SX
    upper: ca.SX
    nearest: ca.SX

    def clip(self, s: ca.SX) -> ca.SX:
        """Return the point of the interval next to s, ``nearest`` where the interval is empty (eq. 15)."""
        return ca.if_else(self.lower <= self.upper, ca.fmin(ca.fmax(s, self.lower), self.upper), self.nearest)


def common(intervals: Sequence[Interval]) -> Interval:
    """Intersect intervals; where nothing is common, the point whose largest distance to them is smallest."""
    lower, upper = intervals[0].lower, intervals[0].upper
    for interval in intervals[1:]:
        lower, upper = ca.fmax(lower, interval.lower), ca.fmin(upper, interval.upper)
    return Interval(lower, upper, 0.5 * (lower + upper))


def band(value: ca.SX, slope: ca.SX, limit: ca.SX) -> Interval:
    """Return where |value + slope s| <= limit; a slope of exactly zero bounds nothing (eq. 12)."""
    flat = slope == 0
    centre, half = -value / slope, limit / ca.fabs(slope)
    lower = ca.if_else(flat, -ca.inf, centre - half)
    upper = ca.if_else(flat, ca.inf, centre + half)
    return Interval(lower, upper, ca.if_else(flat, 0.0, centre))


def above(value: ca.SX, slope: ca.SX) -> Interval:
    """Return where value + slope s >= 0; a slope of exactly zero bounds nothing (eq. 14)."""
    zero = -value / slope
    lower, upper = ca.if_else(slope > 0, zero, -ca.inf), ca.if_else(slope < 0, zero, ca.inf)
    return Interval(lower, upper, ca.if_else(slope == 0, 0.0, zero))


def inside_cone(force: ca.SX, direction: ca.SX, friction: float) -> Interval:
    """Return where the force + direction s lies in the upright friction cone (eq. 13).

    With Q(s) = |f_t|^2 - mu^2 f_z^2 = alpha s^2 + 2 beta s + gamma the cone is Q <= 0 and f_z >= 0. A direction that is
    flatter than the cone (alpha > 0) gives the interval between the roots, a steeper one the half line on which f_z
    grows. Where the line misses the cone, the interval is the one point that minimises Q.

    Args:
        force: world frame, (3,), N.
        direction: (3,).
        friction: coefficient mu.
    """
    squares = ca.SX([1.0, 1.0, -(friction**2)])
    alpha = ca.dot(squares * direction, direction)
    beta = ca.dot(squares * direction, force)
    gamma = ca.dot(squares * force, force)
    alpha = ca.if_else(alpha == 0, 1e-300, alpha)
    lowest = -beta / alpha
    discriminant = beta**2 - alpha * gamma
    misses = ca.logic_and(alpha > 0, ca.logic_or(discriminant <= 0, force[2] + direction[2] * lowest <= 0))
    # the root of larger size first, the other from their product gamma / alpha: no cancellation
    larger = -(beta + ca.if_else(beta >= 0, 1.0, -1.0) * ca.sqrt(ca.fmax(discriminant, 0.0)))
    first = larger / alpha
    second = ca.if_else(larger == 0, first, gamma / larger)
    small, big = ca.fmin(first, second), ca.fmax(first, second)
    upwards, flat = direction[2] > 0, alpha > 0
    lower = ca.if_else(flat, small, ca.if_else(upwards, big, -ca.inf))
    upper = ca.if_else(flat, big, ca.if_else(upwards, ca.inf, small))
    return Interval(ca.if_else(misses, lowest, lower), ca.if_else(misses, lowest, upper), lowest)


def lowest_with_breakpoints(
    curvature: ca.SX, slope: ca.SX, breakpoints: Sequence[ca.SX], weights: Sequence[ca.SX]
) -> ca.SX:
    """Return the s that minimises a s^2 / 2 + b s + sum_j w_j |s - s_j|, a > 0 and w_j >= 0 (eq. 9).

    With p(s) = -(b + sum_j w_j sign(s - s_j)) / a the derivative is a (s - p(s)), and p falls while s rises. So every
    min(s_j, p just left of s_j) is at most the minimiser, and one of them or p(infinity) is the minimiser itself.

    Args:
        curvature: a.
        slope: b.
        breakpoints: s_j, in any order.
        weights: w_j.
    """
    total = sum(weights, ca.SX(0.0))
    best = -(slope + total) / curvature
    for here in breakpoints:
        sides = sum((w * (2.0 * (at < here) - 1.0) for at, w in zip(breakpoints, weights, strict=True)), ca.SX(0.0))
        best = ca.fmax(best, ca.fmin(here, -(slope + sides) / curvature))
    return best


def lowest_peak(values: Sequence[ca.SX], slopes: Sequence[ca.SX]) -> ca.SX:
    """Return the s that minimises max_j |a_j + b_j s| over two or more lines (eq. 10 and 11).

    The minimum t is the highest crossing of a rising with a falling line: of two lines turned so that b_i, b_k >= 0,
    one's positive and the other's negative cross at |b_i a_k - b_k a_i| / (b_i + b_k). All s with |a_j + b_j s| <= t
    are one point, or an interval where lines that hardly rise set the peak; then its middle is taken.

    Args:
        values: a_j.
        slopes: b_j, not all zero.
    """
    b = [ca.fabs(slope) for slope in slopes]
    a = [ca.if_else(slope < 0, -value, value) for value, slope in zip(values, slopes, strict=True)]
    peak = ca.SX(0.0)
    for i, k in combinations(range(len(a)), 2):
        steepness = b[i] + b[k]
        peak = ca.fmax(peak, ca.if_else(steepness > 0, ca.fabs(b[i] * a[k] - b[k] * a[i]) / steepness, 0.0))
    kept = common([band(value, slope, peak) for value, slope in zip(a, b, strict=True)])
    return 0.5 * (kept.lower + kept.upper)
