"""Integrals of sampled quantities that jump at events and, clipped at zero, have corners.

Between two events a quantity is smooth, so it is interpolated there by a cubic spline (not-a-knot; a straight line for
two samples, a parabola for three) and the spline is integrated exactly. Its positive part is integrated exactly too,
between the zeros of every cubic. Since max(., 0) never enlarges a difference, the kink costs no order: the error of
both integrals is O(h^4) in the spacing h of the samples, on any grid.
"""

from __future__ import annotations

from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from amble.errors import InputError
from amble.types import IntegerVector, NodeValues, Vector, frozen

EVEN = 1e-9
"""Spacings of a segment that differ by a smaller share are even; times of 500 cycles round at 1e-11 of a spacing."""

BISECTIONS = 30
"""The integrand vanishes at the zero, so 2^-30 of a piece leaves an error of 2^-60 of it."""


@dataclass(frozen=True)
class PiecewiseCubic:
    """Splines of several quantities over several segments, all intervals in one row.

    Attributes:
        widths: length of every interval, (m,), s.
        coefficients: a_3, a_2, a_1, a_0 of a_3 s^3 + a_2 s^2 + a_1 s + a_0 with s from the interval's start,
            (4, m, width).
    """

    widths: Vector
    coefficients: NodeValues

    def integral(self) -> Vector:
        """Integral of every quantity over all intervals, (width,)."""
        return np.asarray(np.sum(_antiderivative(self.coefficients, self.widths[:, None]), axis=0))

    def positive_integral(self) -> Vector:
        """Integral of max(quantity, 0) over all intervals, (width,)."""
        knots = self._monotone_knots()
        total = np.zeros(self.coefficients.shape[2])
        for first, last in pairwise(knots):
            low, high = self._positive_part(first, last)
            area = _antiderivative(self.coefficients, high) - _antiderivative(self.coefficients, low)
            total += np.sum(area, axis=0)
        return total

    def _monotone_knots(self) -> tuple[Vector, ...]:
        """Ends of every interval and its extrema inside, ascending: between two of them a cubic is monotone."""
        a3, a2, a1, _ = self.coefficients
        start = np.zeros_like(a1)
        end = np.broadcast_to(self.widths[:, None], a1.shape)
        # Roots of 3 a_3 s^2 + 2 a_2 s + a_1 without cancellation; 0/0 (no such root) is mapped to the interval's end.
        root = np.sqrt(np.maximum(np.square(a2) - 3.0 * a3 * a1, 0.0))
        pivot = -(a2 + np.copysign(root, a2))
        with np.errstate(divide="ignore", invalid="ignore"):
            extrema = np.stack([pivot / (3.0 * a3), a1 / pivot])
        extrema = np.where(np.isfinite(extrema), extrema, end)
        inner = np.sort(np.clip(extrema, start, end), axis=0)
        return start, inner[0], inner[1], end

    def _positive_part(self, first: Vector, last: Vector) -> tuple[Vector, Vector]:
        """Limits of the part of each monotone piece where the cubic is positive; empty where it nowhere is."""
        at_first, at_last = _value(self.coefficients, first), _value(self.coefficients, last)
        low, high = first.copy(), last.copy()
        high = np.where((at_first <= 0.0) & (at_last <= 0.0), low, high)
        changes = at_first * at_last < 0.0
        if np.any(changes):
            zero = _bisect(self.coefficients[:, changes], first[changes], last[changes])
            rising = at_last[changes] > 0.0
            low[changes] = np.where(rising, zero, first[changes])
            high[changes] = np.where(rising, last[changes], zero)
        return low, high


def splines(times: Vector, segments: IntegerVector, values: NodeValues) -> PiecewiseCubic:
    """Interpolate samples by one cubic spline per segment.

    Args:
        times: (n,), s, strictly ascending within a segment.
        segments: number of the segment of every sample, (n,); a new number begins a new segment.
        values: (n, width).

    Raises:
        InputError: where a segment has fewer than two samples or its times do not ascend.
    """
    even: dict[int, list[int]] = {}
    pieces: list[tuple[Vector, NodeValues]] = []
    for first, last in segment_bounds(segments):
        spacing = np.diff(times[first:last])
        if spacing.size == 0:
            raise InputError(f"the segment at {times[first]:.6g} s has one sample; an integral needs two")
        if not np.all(spacing > 0.0):
            raise InputError(f"times do not ascend within the segment that begins at {times[first]:.6g} s")
        if np.ptp(spacing) < EVEN * spacing[0]:
            even.setdefault(last - first, []).append(first)
        else:
            pieces.append((spacing, _spline(times[first:last], values[first:last])))
    pieces += [_even_splines(times, values, np.array(starts), samples) for samples, starts in even.items()]
    widths, coefficients = zip(*pieces, strict=True)
    return PiecewiseCubic(frozen(np.concatenate(widths)), frozen(np.concatenate(coefficients, axis=1)))


def _even_splines(times: Vector, values: NodeValues, starts: IntegerVector, samples: int) -> tuple[Vector, NodeValues]:
    """Interpolate all segments of as many evenly spaced samples at once; widths and coefficients as for one."""
    rows = starts + np.arange(samples)[:, None]
    spacing = (times[starts + samples - 1] - times[starts]) / (samples - 1)
    # on a grid of unit spacing: a coefficient of s^k is spacing^k times its size in time
    unit = _spline(np.arange(samples, dtype=np.float64), values[rows])
    powers = spacing[None, :] ** np.arange(len(unit) - 1, -1, -1)[:, None]
    scaled = unit / powers[:, None, :, None]
    intervals = samples - 1
    return np.tile(spacing, intervals), scaled.reshape(len(unit), intervals * starts.size, -1)


def _spline(times: Vector, values: NodeValues) -> NodeValues:
    """Coefficients of the cubic spline through samples, (4, n - 1, ...)."""
    # scipy.interpolate is slow to import, and the package must start fast
    from scipy.interpolate import CubicSpline

    return np.asarray(CubicSpline(times, values).c)


def segment_bounds(segments: IntegerVector) -> list[tuple[int, int]]:
    """First and past-the-last sample of every run of equal numbers."""
    changes = np.flatnonzero(np.diff(segments) != 0) + 1
    edges = [0, *changes.tolist(), len(segments)]
    return list(pairwise(edges))


def _value(coefficients: NodeValues, s: Vector) -> Vector:
    a3, a2, a1, a0 = coefficients
    return ((a3 * s + a2) * s + a1) * s + a0


def _antiderivative(coefficients: NodeValues, s: Vector) -> Vector:
    a3, a2, a1, a0 = coefficients
    return (((a3 / 4.0 * s + a2 / 3.0) * s + a1 / 2.0) * s + a0) * s


def _bisect(coefficients: NodeValues, first: Vector, last: Vector) -> Vector:
    """Find the zero of every cubic between two points where its signs differ."""
    positive_first = _value(coefficients, first) > 0.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (first + last)
        same = (_value(coefficients, middle) > 0.0) == positive_first
        first, last = np.where(same, middle, first), np.where(same, last, middle)
    return 0.5 * (first + last)
