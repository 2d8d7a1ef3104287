"""Perturbed starts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amble.errors import InputError
from amble.simulation.perturbation import perturbed

STATE = np.linspace(-1.0, 1.0, 36)


@pytest.mark.parametrize("seed", range(3))
def test_every_state_moves_by_no_more_than_the_size(seed: int) -> None:
    change = perturbed(STATE, 1e-3, seed) - STATE
    assert np.abs(change).max() <= 1e-3 * (1 + 1e-12)
    assert np.count_nonzero(change) == STATE.size


def test_the_seed_decides() -> None:
    assert np.array_equal(perturbed(STATE, 1e-3, 1), perturbed(STATE, 1e-3, 1))
    assert not np.array_equal(perturbed(STATE, 1e-3, 1), perturbed(STATE, 1e-3, 2))
    assert np.array_equal(perturbed(STATE, 0.0, 1), STATE)


@pytest.mark.parametrize("size", [-1e-3, math.nan, math.inf])
def test_a_size_that_makes_no_sense_is_refused(size: float) -> None:
    with pytest.raises(InputError, match="size of a perturbation"):
        perturbed(STATE, size, 0)
