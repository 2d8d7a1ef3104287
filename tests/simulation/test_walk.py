"""Motions that end without a transition are named for what they are."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import simulate
from tests.hybrids import bouncing_ball


def test_bounces_told_in_two_domains_accumulate_too() -> None:
    x = ca.SX.sym("x", 2)
    domains = [Domain.from_expressions(name, x, ca.vertcat(x[1], -9.81)) for name in ("up", "down")]
    top = Transition.from_expressions("up", "down", x, x[1], x, -1)
    bounce = Transition.from_expressions("down", "up", x, x[0], ca.vertcat(0, -0.7 * x[1]), -1)
    trace = simulate(HybridSystem(domains, [top, bounce]), np.array([0.0, 2.0]), 2000)
    assert trace.ended.startswith("the motion has events that accumulate (Zeno)")
    assert trace.time[-1] == pytest.approx(2 * 2.0 / 9.81 / 0.3, rel=1e-6)


def test_short_stays_that_do_not_shrink_to_nothing_go_on() -> None:
    """A domain of a few nanoseconds whose length comes to its limit from above."""
    x = ca.SX.sym("x", 2)
    domains = [Domain.from_expressions(name, x, ca.vertcat(1, 0)) for name in ("long", "short")]
    after = ca.vertcat(0, 0.5 * x[1] + 1e-9)
    transitions = [
        Transition.from_expressions("long", "short", x, x[0] - 1, after, +1),
        Transition.from_expressions("short", "long", x, x[0] - x[1], ca.vertcat(0, x[1]), +1),
    ]
    assert simulate(HybridSystem(domains, transitions), np.array([0.0, 3e-9]), 100, samples=2).completed


@pytest.mark.parametrize("restitution", [0.99, 0.8, 0.5, *np.random.default_rng(3).uniform(0.1, 0.95, 4)])
def test_a_ball_whose_bounces_accumulate_is_named(restitution: float) -> None:
    trace = simulate(bouncing_ball(restitution), np.array([0.0, 2.0]), 3000)
    assert trace.ended.startswith("the motion has events that accumulate (Zeno)")
    # where the bounces accumulate: a geometric series
    assert trace.time[-1] == pytest.approx(2 * 2.0 / 9.81 / (1 - restitution), rel=1e-6)
    assert -1e-12 < trace.state[:, 0].min() <= trace.state[:, 0].max() < 0.3  # it does not fall through the floor
    assert trace.section.shape == (trace.cycles + 1, 2)


def relay(slope: float) -> HybridSystem:
    """x'' = -sign(x + slope x'): near the origin both sides push to the surface."""
    x = ca.SX.sym("x", 2)
    surface = x[0] + slope * x[1]
    above = Domain.from_expressions("above", x, ca.vertcat(x[1], -1))
    below = Domain.from_expressions("below", x, ca.vertcat(x[1], 1))
    down = Transition.from_expressions("above", "below", x, surface, x, -1)
    up = Transition.from_expressions("below", "above", x, surface, x, +1)
    return HybridSystem([above, below], [down, up])


@pytest.mark.parametrize("slope", [0.3, *np.random.default_rng(4).uniform(0.1, 1.0, 4)])
def test_sliding_is_named(slope: float) -> None:
    trace = simulate(relay(slope), np.array([1.0, 0.0]), 50)
    assert "is zero at the entry and passes it at once" in trace.ended
    assert "the motion slides along it" in trace.ended
    assert "time_limit is 10 s" in trace.ended


@pytest.mark.parametrize("seed", range(4))
def test_a_guard_past_zero_that_moves_away_is_named(seed: int) -> None:
    random = np.random.default_rng(seed)
    start = np.array([-random.uniform(0.01, 1.0), -random.uniform(0.0, 2.0)])
    trace = simulate(bouncing_ball(), start, 1, time_limit=random.uniform(1.0, 10.0))
    assert "the guard of 'flight->flight' was past zero at the entry and moved away" in trace.ended


def test_a_guard_that_is_only_far_away_is_not_blamed() -> None:
    trace = simulate(bouncing_ball(), np.array([100.0, 0.0]), 1, time_limit=1.0)
    assert trace.ended == (
        "the motion reached no guard within the time limit in domain 'flight' of cycle 0 at 1 s (time_limit is 1 s)"
    )


def test_a_motion_that_never_enters_its_first_domain_again_ends() -> None:
    x = ca.SX.sym("x", 1)
    domains = [Domain.from_expressions(name, x, ca.SX(1)) for name in ("once", "ever")]
    steps = [Transition.from_expressions(*pair, x, x - 1, x * 0, +1) for pair in (("once", "ever"), ("ever", "ever"))]
    trace = simulate(HybridSystem(domains, steps), np.zeros(1), 1, samples=2)
    assert "has not entered the first domain again after 10000 events in domain 'ever'" in trace.ended


@pytest.mark.parametrize("max_step", [0.0, -1.0, float("nan"), 1e-12])
def test_the_longest_step_is_a_time(max_step: float) -> None:
    with pytest.raises(InputError, match="max_step is a time of at least 1e-10 s"):
        simulate(bouncing_ball(), np.array([0.0, 1.0]), 1, max_step=max_step)
