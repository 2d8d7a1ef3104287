"""A gait simulated: lost rank is an error while the motion goes on, and a fall is a trace."""

from __future__ import annotations

import pytest

from amble.errors import WorkError
from amble.gait import Gait
from amble.simulation import simulate_gait, walking


def test_a_motion_that_goes_on_without_rank_is_refused(monkeypatch: pytest.MonkeyPatch, stabilised_gait: Gait) -> None:
    assert simulate_gait(stabilised_gait, 1).completed
    monkeypatch.setattr(walking, "SMALLEST_PIVOT", 1.0)  # pivots are sines, so that none reaches it
    with pytest.raises(WorkError, match=r"lose rank in domain 'D\d' at .* smallest pivot 0\.\d+, at least 1 is needed"):
        simulate_gait(stabilised_gait, 1)


def test_a_fall_is_a_trace_whatever_its_pivots(monkeypatch: pytest.MonkeyPatch, stabilised_gait: Gait) -> None:
    monkeypatch.setattr(walking, "SMALLEST_PIVOT", 1.0)
    trace = simulate_gait(stabilised_gait, 5, perturbation=0.5)
    assert not trace.completed
    assert trace.ended.startswith("the motion")
