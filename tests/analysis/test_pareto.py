"""Choices that no other one beats."""

from __future__ import annotations

import itertools

import numpy as np
import pytest

from amble.analysis.pareto import undominated


@pytest.mark.parametrize("seed", range(5))
def test_the_front_is_a_rising_staircase_above_all_others(seed: int) -> None:
    """Law: along the front more cost gives more; every other choice has one of the front that beats it."""
    generator = np.random.default_rng(seed)
    costs, gains = generator.integers(0, 12, (2, 30)).astype(float)
    best = undominated(list(costs), list(gains))
    front = sorted({(cost, gain) for cost, gain, on in zip(costs, gains, best, strict=True) if on})
    assert all(a[0] < b[0] and a[1] < b[1] for a, b in itertools.pairwise(front))
    for cost, gain, on in zip(costs, gains, best, strict=True):
        beaten = [(c, g) for c, g in front if c <= cost and g >= gain and (c, g) != (cost, gain)]
        assert on != bool(beaten)


def test_equal_choices_stand_together() -> None:
    assert undominated([1.0, 1.0, 2.0], [3.0, 3.0, 3.0]) == [True, True, False]
