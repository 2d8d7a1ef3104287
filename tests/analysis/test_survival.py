"""Walks from changed starts: none that is not changed falls, and a fall is counted where it happens."""

from __future__ import annotations

import pytest

from amble.analysis import survived_cycles
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait
from tests.conftest import DATA


def test_small_changes_survive_and_large_ones_do_not(stabilised_gait: Gait) -> None:
    """A state changed by its whole unit is half a leg length off: no gait walks from there."""
    found = survived_cycles(stabilised_gait, (0.0, 1e-4, 1.0), starts=2, cycles=3, friction=0.8)
    assert found == {0.0: (3, 3), 1e-4: (3, 3), 1.0: (0, 0)}


def test_sound_cycles_alone_count(stabilised_gait: Gait) -> None:
    """The gait uses 0.594 of a friction of 0.6: with a little less no cycle is sound, though none falls."""
    assert survived_cycles(stabilised_gait, (0.0,), starts=1, cycles=2, friction=0.59) == {0.0: (0,)}
    trot = load_gait(DATA / "stabilised-trot-one-by-one.json")
    assert survived_cycles(trot, (0.0,), starts=1, cycles=2) == {0.0: (2,)}
    assert survived_cycles(trot, (0.0,), starts=1, cycles=2, friction=0.59) == {0.0: (0,)}


def test_no_start_and_no_size_are_refused(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="0 starts were asked for"):
        survived_cycles(stabilised_gait, (1e-3,), starts=0)
    with pytest.raises(InputError, match="finite and not negative"):
        survived_cycles(stabilised_gait, (-1e-3,))
