"""Gains change no more than the radius asks."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.progress import silent
from amble.stability import stabilize
from amble.stability.gain_search import GainSearch
from amble.stability.nearest_gains import nearest_gains
from amble.stability.weight_search import Closed
from amble.types import Vector


@pytest.fixture(scope="module")
def start(gain_search: GainSearch) -> Closed:
    return gain_search.close(np.zeros(gain_search.size))


def test_gains_that_are_good_enough_stay(gain_search: GainSearch, start: Closed) -> None:
    """Default gains: 0.660."""
    found, reason = nearest_gains(gain_search, start, 0.95, silent)
    assert found is start
    assert reason == "a spectral radius of 0.95 is enough"


def test_one_quadratic_function_has_to_serve_all_orders_of_landing(
    start: Closed, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Of Go2's trot each order's radius was 0.86, their common bound 1.24: no certificate."""
    found = iter([(0.8, 1.2), (0.85, 0.9), (0.1, 0.2)])

    def close(theta: Vector) -> Closed:
        radius, bound = next(found)
        return replace(start, theta=theta, passages=2 * start.passages, radius=radius, bound=bound)

    search: Any = SimpleNamespace(evaluate=None, bounds=None, radius=lambda _: 0.5, close=close)
    monkeypatch.setattr("amble.stability.nearest_gains.least_bound", lambda _, theta, *__, **___: theta + 1.0)
    ends, reason = nearest_gains(search, replace(start, passages=2 * start.passages, bound=1.3), 0.95, silent)
    assert (ends.radius, ends.bound) == (0.85, 0.9)
    assert reason == "gains nearest to those of the start with a spectral radius of at most 0.95"


def test_radius_along_the_stored_orbit_is_that_of_the_closed_loop(gain_search: GainSearch, start: Closed) -> None:
    """Two code paths: collocation on the orbit, and the integrated variational equations."""
    assert gain_search.radius(start.theta) == pytest.approx(start.radius, abs=1e-5)


def test_cost_of_a_change_has_the_slope_of_differences(gain_search: GainSearch) -> None:
    theta = np.random.default_rng(3).normal(0.0, 0.3, gain_search.size)
    direction = np.random.default_rng(4).normal(size=gain_search.size)
    ahead, behind = (gain_search.evaluate(theta + sign * 1e-4 * direction).conditioning()[0] for sign in (1.0, -1.0))
    assert (ahead - behind) / 2e-4 == pytest.approx(
        float(gain_search.evaluate(theta).conditioning()[1] @ direction), rel=1e-6
    )


@pytest.mark.slow
def test_a_smaller_radius_asks_for_a_larger_change(gain_search: GainSearch, start: Closed) -> None:
    """Each is reached; the orbit does not move."""
    changes = []
    for target in (0.6, 0.4):
        found, _ = nearest_gains(gain_search, start, target, silent)
        assert found.radius <= target
        assert found.drift < 1e-8
        changes.append(float(np.linalg.norm(found.theta)))
    assert 0.0 < changes[0] < changes[1]


@pytest.mark.slow
def test_stabilisation_ends_where_the_radius_is_reached(stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    """From 0.660, by gains; the orbit does not move."""
    monkeypatch.setattr(stabilize, "TARGET", 0.5)
    found = stabilize.stabilization(replace(stabilised_gait, control=Impedance()))
    assert found.initial == pytest.approx(0.660, abs=0.005)
    assert found.radius <= 0.5
    assert found.parameters == 48
    assert all(step.drift < 1e-8 for step in found.steps)
