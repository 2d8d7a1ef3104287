"""Shares of trials against scipy, and thresholds where they are known."""

from __future__ import annotations

import numpy as np
import pytest
from scipy import optimize, stats

from amble.analysis.proportions import falling_share, half_survives, rank_correlation, wilson
from amble.errors import InputError


@pytest.mark.parametrize(("successes", "trials"), [(0, 1), (0, 20), (7, 20), (20, 20), (499, 1000)])
def test_wilsons_interval_is_that_of_scipy(successes: int, trials: int) -> None:
    expected = stats.binomtest(successes, trials).proportion_ci(method="wilson")
    assert wilson(successes, trials) == pytest.approx((expected.low, expected.high), abs=1e-12)


@pytest.mark.parametrize(("successes", "trials", "quantile"), [(7, 20, 1.0), (499, 1000, 1.96), (3, 9, 2.6)])
def test_its_ends_are_as_far_from_the_share_as_the_quantile_says(successes: int, trials: int, quantile: float) -> None:
    for end in wilson(successes, trials, quantile):
        distance = abs(successes / trials - end) / np.sqrt(end * (1.0 - end) / trials)
        assert distance == pytest.approx(quantile, rel=1e-9)


def test_no_share_has_no_interval() -> None:
    for wrong in ((1, 0), (3, 2), (-1, 2)):
        with pytest.raises(InputError, match="is no share"):
            wilson(*wrong)


@pytest.mark.parametrize("seed", range(5))
def test_the_falling_share_is_isotonic_regression(seed: int) -> None:
    survived = np.random.default_rng(seed).integers(0, 2, 50).astype(float)
    expected = optimize.isotonic_regression(survived, increasing=False).x
    np.testing.assert_allclose(falling_share(survived), expected, atol=1e-12)


def test_the_falling_share_falls_and_is_the_mean_of_what_it_pools() -> None:
    survived = np.random.default_rng(9).integers(0, 2, 200).astype(float)
    shares = falling_share(survived)
    assert np.all(np.diff(shares) <= 0.0)
    for share in np.unique(shares):
        assert np.mean(survived[shares == share]) == pytest.approx(share, abs=1e-12)
    assert falling_share(np.zeros(0)).size == 0


def test_half_survives_where_a_logistic_curve_says_so() -> None:
    """4,000 trials of a chance 1 / (1 + (size / 3)^4), half of which survive at 3: to 10 %."""
    generator = np.random.default_rng(2)
    sizes = generator.uniform(0.0, 10.0, 4000)
    survived = generator.uniform(size=4000) < 1.0 / (1.0 + (sizes / 3.0) ** 4)
    assert half_survives(sizes, survived) == pytest.approx(3.0, rel=0.1)


def test_a_threshold_beyond_what_was_tried_is_not_known() -> None:
    assert half_survives([1.0, 2.0], [True, True]) is None
    assert half_survives([1.0, 2.0], [False, False]) == 0.0
    assert half_survives([2.0, 1.0], [False, True]) == 1.5


def test_rank_correlation_is_spearmans() -> None:
    generator = np.random.default_rng(4)
    first = generator.integers(0, 8, 40).astype(float)  # with equal values
    second = first + generator.normal(0.0, 3.0, 40)
    assert rank_correlation(first, second) == pytest.approx(stats.spearmanr(first, second).statistic, abs=1e-12)
    ranks = [np.array([np.sum(part < x) + 0.5 * np.sum(part == x) for x in part]) for part in (first, second)]
    assert rank_correlation(first, second) == pytest.approx(np.corrcoef(ranks[0], ranks[1])[0, 1], abs=1e-12)
    assert rank_correlation([1.0, 1.0], [1.0, 2.0]) is None
    assert rank_correlation([1.0], [1.0]) is None
