"""The closed forms on a line against brute force."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.control.allocation.line import (
    Interval,
    above,
    band,
    common,
    inside_cone,
    lowest_peak,
    lowest_with_breakpoints,
)

GRID = np.linspace(-50.0, 50.0, 200001)
STEP = GRID[1] - GRID[0]


def number(value: ca.SX) -> float:
    return float(ca.DM(value))


@pytest.mark.parametrize("seed", range(30))
def test_lowest_with_kinks(seed: int) -> None:
    generator = np.random.default_rng(seed)
    count = int(generator.integers(0, 8))
    a, b = generator.uniform(0.1, 3.0), generator.normal(0.0, 5.0)
    breakpoints, weights = generator.normal(0.0, 5.0, count), np.abs(generator.normal(0.0, 4.0, count))
    if count > 2:
        breakpoints[1], weights[2] = breakpoints[0], 0.0  # equal breakpoints, and one without weight
    s = number(
        lowest_with_breakpoints(ca.SX(a), ca.SX(b), [ca.SX(k) for k in breakpoints], [ca.SX(w) for w in weights])
    )

    def cost(at: np.ndarray) -> np.ndarray:
        return 0.5 * a * at**2 + b * at + np.sum(weights[:, None] * np.abs(at - breakpoints[:, None]), axis=0)

    assert cost(np.array([s]))[0] <= cost(GRID).min() + 1e-12
    assert s == pytest.approx(GRID[np.argmin(cost(GRID))], abs=2.0 * STEP)


@pytest.mark.parametrize("seed", range(30))
def test_lowest_peak(seed: int) -> None:
    generator = np.random.default_rng(seed)
    count = int(generator.integers(2, 8))
    values, slopes = generator.normal(0.0, 5.0, count), generator.normal(0.0, 1.0, count)
    if count > 3:
        slopes[1] = 0.0
    s = number(lowest_peak([ca.SX(value) for value in values], [ca.SX(slope) for slope in slopes]))
    peaks = np.max(np.abs(values[:, None] + slopes[:, None] * GRID), axis=0)
    assert np.max(np.abs(values + slopes * s)) <= peaks.min() + 1e-12


@pytest.mark.parametrize("seed", range(60))
def test_inside_cone(seed: int) -> None:
    """Steep and flat directions, lines that hit the cone and lines that miss it, pushing and pulling."""
    generator = np.random.default_rng(seed)
    friction = generator.uniform(0.3, 1.0)
    force, direction = generator.normal(0.0, 5.0, 3), generator.normal(0.0, 1.0, 3)
    direction[2] *= generator.choice([0.0, 0.1, 3.0])
    found = inside_cone(ca.SX(force), ca.SX(direction), friction)
    lower, upper = number(found.lower), number(found.upper)
    f = force[:, None] + direction[:, None] * GRID
    inside = np.flatnonzero(np.hypot(f[0], f[1]) <= friction * f[2])
    if inside.size == 0:
        assert upper - lower <= STEP or lower > GRID[-1] or upper < GRID[0]
        return
    assert max(lower, GRID[0]) == pytest.approx(GRID[inside[0]], abs=1.01 * STEP)
    assert min(upper, GRID[-1]) == pytest.approx(GRID[inside[-1]], abs=1.01 * STEP)


def test_a_cone_that_is_missed_is_one_point_where_the_line_is_closest() -> None:
    found = inside_cone(ca.SX([3.0, 4.0, 1.0]), ca.SX([1.0, 0.0, 0.0]), 0.5)
    assert [number(part) for part in (found.lower, found.upper, found.nearest)] == [-3.0, -3.0, -3.0]


@pytest.mark.parametrize(("value", "slope", "limit"), [(3.0, 2.0, 5.0), (3.0, -2.0, 5.0), (-1.0, 1e-9, 2.0)])
def test_band_and_above(value: float, slope: float, limit: float) -> None:
    found = band(ca.SX(value), ca.SX(slope), ca.SX(limit))
    for end in (found.lower, found.upper):
        assert abs(value + slope * number(end)) == pytest.approx(limit, rel=1e-12)
    half = above(ca.SX(value), ca.SX(slope))
    ends = number(half.lower), number(half.upper)
    assert ends == ((-value / slope, np.inf) if slope > 0.0 else (-np.inf, -value / slope))


def test_what_is_flat_bounds_nothing() -> None:
    for found in (band(ca.SX(9.0), ca.SX(0.0), ca.SX(1.0)), above(ca.SX(-9.0), ca.SX(0.0))):
        assert (number(found.lower), number(found.upper)) == (-np.inf, np.inf)
        assert number(found.clip(ca.SX(4.0))) == 4.0


@pytest.mark.parametrize("seed", range(20))
def test_nested_clipping_equals_clipping_into_the_intersection(seed: int) -> None:
    generator = np.random.default_rng(seed)
    centre = generator.normal()
    ends = [sorted(centre + generator.uniform([-3.0, 0.0], [0.0, 3.0])) for _ in range(3)]
    intervals = [Interval(ca.SX(low), ca.SX(high), ca.SX(np.nan)) for low, high in ends]
    s = ca.SX(generator.normal(0.0, 5.0))
    nested = s
    for interval in intervals:
        nested = interval.clip(nested)
    assert number(nested) == number(common(intervals).clip(s))


def test_intervals_with_nothing_in_common_meet_halfway() -> None:
    found = common([Interval(ca.SX(0.0), ca.SX(1.0), ca.SX(0.5)), Interval(ca.SX(3.0), ca.SX(4.0), ca.SX(3.5))])
    assert number(found.clip(ca.SX(10.0))) == 2.0
