"""Stance tables from duty factors: every foot stands for its share, and the gaits that are known come out."""

from __future__ import annotations

import numpy as np
import pytest

from amble.errors import InputError
from amble.hybrid import Footfall, stance_table


@pytest.mark.parametrize("seed", range(8))
def test_feet_stand_for_their_duty_factor(seed: int) -> None:
    generator = np.random.default_rng(seed)
    falls = {f"foot {k}": Footfall(*generator.uniform([-2.0, 0.1], [2.0, 0.95])) for k in range(2 + seed % 5)}
    rows = stance_table(falls)
    events = sorted((fall.phase + part) % 1.0 for fall in falls.values() for part in (0.0, fall.duty))
    lengths = np.diff([*events, events[0] + 1.0])
    assert len(rows) == len(events)
    for foot, fall in falls.items():
        stands = sum(length for row, length in zip(rows, lengths, strict=True) if foot in row)
        assert stands == pytest.approx(fall.duty)


def test_events_at_one_instant_are_one_switch() -> None:
    third = 1.0 / 3.0
    falls = {"a": Footfall(0.0, third), "b": Footfall(third, third), "c": Footfall(2.0 * third, 1.0 - 2.0 * third)}
    assert stance_table(falls) == (("a",), ("b",), ("c",))
    assert stance_table({"a": Footfall(-1e-12, 0.5), "b": Footfall(0.5, 0.5)}) == (("a",), ("b",))


def test_a_foot_with_duty_one_never_lifts() -> None:
    assert stance_table({"a": Footfall(0.3, 1.0), "b": Footfall(0.0, 0.5)}) == (("a", "b"), ("a",))
    assert stance_table({"a": Footfall(0.0, 1.0)}) == ()


@pytest.mark.parametrize(("phase", "duty"), [(float("nan"), 0.5), (0.0, 0.0), (0.0, 1.1), (0.0, float("nan"))])
def test_footfalls_that_are_none(phase: float, duty: float) -> None:
    with pytest.raises(InputError, match="of a footfall is"):
        Footfall(phase, duty)
