"""The return map under other weights of a gait whose feet leave by their force, which feedback moves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.defaults import FREE
from amble.gait.closed_loop import closed_loop
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.stability.closed_loop_orbit import without_yaw
from amble.stability.gain_search import GainSearch
from amble.stability.monodromy import monodromy
from amble.stability.stabilize import stabilization
from amble.stability.weight_search import WeightSearch
from amble.synthesis import gait_problem, synthesize

BIPED = Path(__file__).parents[1] / "data" / "biped-of-small-basin.json"


@pytest.fixture(scope="module")
def search() -> WeightSearch:
    """Of a biped that runs: its feet leave by their force."""
    problem = gait_problem(load_gait(BIPED).robot, "run", speed=0.4)
    return WeightSearch.of(synthesize(replace(problem, intervals=5)), FREE)


def test_a_lift_off_follows_the_weights(search: WeightSearch) -> None:
    """Collocation on the stored orbit against the adaptive flow of the closed loop, which differentiates the guard.

    Under other weights the closed loop leaves the stored orbit by what the references miss of it, about 1e-6.
    """
    theta = np.random.default_rng(1).normal(scale=0.1, size=search.size)
    system = without_yaw(closed_loop(search.gait_with(theta), half=True), True)
    expected = search.orbit.dual @ monodromy(system, search.orbit.start).matrix @ search.orbit.basis
    found = search.evaluate(theta).matrices[0]
    assert np.abs(found - expected).max() < 1e-4 * np.abs(expected).max()


def test_gradients_are_those_of_central_differences(search: WeightSearch) -> None:
    """Of a random linear function of the map, and of the conditioning; the step 1e-4 leaves its square."""
    generator = np.random.default_rng(2)
    theta = generator.normal(scale=0.1, size=search.size)
    here = search.evaluate(theta)
    outer = generator.normal(size=here.matrices[0].shape)
    slopes = here.gradient([outer]), here.conditioning()[1]
    direction = generator.normal(size=search.size)
    ahead, behind = (search.evaluate(theta + step * direction) for step in (1e-4, -1e-4))
    moved = float(((ahead.matrices[0] - behind.matrices[0]) * outer).sum()), ahead.conditioning()[0]
    assert moved[0] / 2e-4 == pytest.approx(float(slopes[0] @ direction), rel=1e-5)
    assert (moved[1] - behind.conditioning()[0]) / 2e-4 == pytest.approx(float(slopes[1] @ direction), rel=1e-5)


def test_gains_move_a_lift_off_too(search: WeightSearch) -> None:
    """Under torques of joint errors: the map against the adaptive flow, and its gradient against differences."""
    gains = GainSearch.of(replace(search.gait, control=Impedance(stance_stiffness=100.0)))
    generator = np.random.default_rng(3)
    theta = generator.normal(scale=0.1, size=gains.size)
    values = dict(zip(gains.labels, gains.values(theta), strict=True))
    system = without_yaw(closed_loop(replace(gains.gait, control=gains.law.with_gains(values)), half=True), True)
    expected = gains.orbit.dual @ monodromy(system, gains.orbit.start).matrix @ gains.orbit.basis
    here = gains.evaluate(theta)
    assert np.abs(here.matrices[0] - expected).max() < 1e-5 * np.abs(expected).max()
    outer, direction = generator.normal(size=expected.shape), generator.normal(size=gains.size)
    ahead, behind = (gains.evaluate(theta + step * direction).matrices[0] for step in (1e-4, -1e-4))
    moved = float(((ahead - behind) * outer).sum()) / 2e-4
    assert moved == pytest.approx(float(here.gradient([outer]) @ direction), rel=1e-4)


@pytest.mark.slow
def test_a_run_is_stabilised(search: WeightSearch) -> None:
    found = stabilization(search.gait)
    assert found.radius < 0.9 < found.initial
