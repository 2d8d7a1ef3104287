"""Perturbed starts."""

from __future__ import annotations

import math

import numpy as np
import pytest

from amble.errors import InputError
from amble.simulation.perturbation import perturbed

STATE = np.linspace(-1.0, 1.0, 36)


@pytest.mark.parametrize("seed", range(3))
def test_every_state_moves_by_the_size_in_both_directions(seed: int) -> None:
    change = perturbed(STATE, 1e-3, seed) - STATE
    assert np.allclose(np.abs(change), 1e-3, rtol=1e-12)
    assert change.min() < 0.0 < change.max()


def test_the_seed_decides() -> None:
    assert np.array_equal(perturbed(STATE, 1e-3, 1), perturbed(STATE, 1e-3, 1))
    assert not np.array_equal(perturbed(STATE, 1e-3, 1), perturbed(STATE, 1e-3, 2))
    assert np.array_equal(perturbed(STATE, 0.0, 1), STATE)


@pytest.mark.parametrize("size", [-1e-3, math.nan, math.inf])
def test_a_size_that_makes_no_sense_is_refused(size: float) -> None:
    with pytest.raises(InputError, match="size of a perturbation"):
        perturbed(STATE, size, 0)
