"""Laws by name."""

from __future__ import annotations

import pytest

from amble.control.allocation import DropActuator, PseudoInverse
from amble.control.laws import law_for, paper_baseline
from amble.errors import UnknownNameError
from amble.hybrid.gaits import amble
from amble.robot import catalogue

PATTERN = amble(catalogue.astro())


def test_the_baseline_drops_the_rear_stance_hip_pitch() -> None:
    assert paper_baseline(PATTERN) == DropActuator(("rl_hip_pitch", "rr_hip_pitch"))


def test_laws_are_found_by_name() -> None:
    assert law_for(PATTERN, "pinv") == PseudoInverse()
    assert law_for(PATTERN, "drop") == paper_baseline(PATTERN)
    assert law_for(PATTERN, "drop", {"joints": ["fr_knee", "fl_knee"]}) == DropActuator(("fr_knee", "fl_knee"))


def test_an_unknown_law_or_parameter_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="known: pinv, drop"):
        law_for(PATTERN, "best")
    with pytest.raises(UnknownNameError, match="parameter of allocation law 'pinv' 'power'"):
        law_for(PATTERN, "pinv", {"power": 2})
