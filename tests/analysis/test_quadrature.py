"""Integrals of sampled, jumping and clipped quantities against closed forms."""

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

from amble.analysis.quadrature import segment_bounds, splines
from amble.errors import InputError


def sine(count: int, uneven: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Samples of sin(2 pi t) over three quarters of a period, evenly or unevenly spaced."""
    grid = np.linspace(0.0, 1.0, count)
    times = 0.75 * (grid + (0.1 * np.sin(np.pi * grid) if uneven else 0.0))
    return times, np.sin(2.0 * np.pi * times)[:, None]


@pytest.mark.parametrize("uneven", [False, True])
@pytest.mark.parametrize("positive", [False, True])
def test_order_four_with_and_without_the_kink(uneven: bool, positive: bool) -> None:
    """Regression of the error on the spacing: the breakpoint of max(., 0) must not cost order."""
    # int_0^{3/4} sin = 1/(2 pi); its positive part over the half period is 1/pi
    exact = 1.0 / np.pi if positive else 0.5 / np.pi
    counts = np.array([33, 65, 129, 257])
    errors = []
    for count in counts:
        cubics = splines(sine(count, uneven)[0], np.zeros(count), sine(count, uneven)[1])
        found = cubics.positive_integral() if positive else cubics.integral()
        errors.append(abs(float(found[0]) - exact))
    slope = -np.polyfit(np.log(counts - 1.0), np.log(errors), 1)[0]
    assert slope > 3.7  # four in the limit; coarser grids err with changing signs
    assert errors[-1] < 1e-9


def test_cubics_are_integrated_exactly() -> None:
    """A cubic with three zeros and a coarse uneven grid: the positive part has the closed form of its pieces."""
    polynomial = np.poly1d(np.poly([0.13, 0.52, 0.9]))
    times = np.array([0.0, 0.35, 0.6, 1.0])
    primitive = polynomial.integ()
    exact = primitive(0.52) - primitive(0.13) + primitive(1.0) - primitive(0.9)
    cubics = splines(times, np.zeros(4), polynomial(times)[:, None])
    assert cubics.positive_integral()[0] == pytest.approx(exact, rel=1e-12)
    assert cubics.integral()[0] == pytest.approx(primitive(1.0), rel=1e-12)


def test_positive_minus_negative_part_is_the_integral() -> None:
    random = np.random.default_rng(2)
    times = np.sort(random.uniform(size=40))
    values = random.normal(size=(40, 5))
    segments = np.repeat([0, 1, 2], [11, 2, 27])
    plus = splines(times, segments, values)
    minus = splines(times, segments, -values)
    # round-off of random splines whose overshoot is of size 1e1 to 1e2
    assert np.allclose(plus.positive_integral() - minus.positive_integral(), plus.integral(), rtol=0.0, atol=1e-10)
    assert np.all(plus.positive_integral() >= 0.0)


@pytest.mark.parametrize("value", [-3.0, 0.0, 3.0])
def test_constants(value: float) -> None:
    cubics = splines(np.array([0.0, 0.5, 2.0]), np.zeros(3), np.full((3, 1), value))
    assert cubics.integral()[0] == pytest.approx(2.0 * value, abs=1e-14)
    assert cubics.positive_integral()[0] == pytest.approx(2.0 * max(value, 0.0), abs=1e-14)


def test_no_integral_runs_across_an_event() -> None:
    """A step at a doubled time is integrated as two constants."""
    times = np.array([0.0, 1.0, 1.0, 3.0])
    values = np.array([[2.0], [2.0], [-5.0], [-5.0]])
    cubics = splines(times, np.array([0, 0, 1, 1]), values)
    assert cubics.integral()[0] == pytest.approx(2.0 - 10.0, abs=1e-14)
    assert cubics.positive_integral()[0] == pytest.approx(2.0, abs=1e-14)


def test_segments_are_runs() -> None:
    assert segment_bounds(np.array([4, 4, 7, 4, 4])) == [(0, 2), (2, 3), (3, 5)]


def test_one_sample_or_times_that_stand_still_are_refused() -> None:
    with pytest.raises(InputError, match="one sample"):
        splines(np.array([0.0, 1.0, 1.0]), np.array([0, 0, 1]), np.zeros((3, 1)))
    with pytest.raises(InputError, match="do not ascend"):
        splines(np.array([0.0, 1.0, 1.0]), np.zeros(3), np.zeros((3, 1)))


def test_evenly_spaced_segments_are_splines_of_their_own() -> None:
    """All segments of as many samples are interpolated at once; scipy's splines, one by one, are the oracle."""
    random = np.random.default_rng(4)
    counts, spacings = [7, 5, 7, 9, 2, 3], [0.1, 0.2, 0.03, 0.05, 0.4, 0.1]
    times = np.concatenate([100.0 + step * np.arange(n) for n, step in zip(counts, spacings, strict=True)])
    segments, values = np.repeat(np.arange(6), counts), random.normal(size=(sum(counts), 2))
    expected = np.zeros(2)
    for number in range(6):
        t, y = times[segments == number], values[segments == number]
        expected += CubicSpline(t, y).integrate(t[0], t[-1])
    # clocks near 100 round at 1e-14, a share of 1e-12 of the spacing
    np.testing.assert_allclose(splines(times, segments, values).integral(), expected, atol=1e-11)
