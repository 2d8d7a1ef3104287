"""Two bodies that fall onto the ground one after the other, or at once: no landing is missed, whatever the order."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import simulate
from amble.stability import fixed_point, multipliers

SPEEDS, PERIOD = (1.0, 1.5), 0.4


def falling(at_entry: bool) -> HybridSystem:
    """Heights (a, b); each falls at its speed until it lands, and both are thrown up when the second has landed."""
    x, t = ca.SX.sym("x", 2), ca.SX.sym("t")
    domains = [
        Domain.from_expressions("both", x, -ca.DM(SPEEDS), t),
        Domain.from_expressions("a down", x, ca.vertcat(0.0, -SPEEDS[1]), t),
        Domain.from_expressions("b down", x, ca.vertcat(-SPEEDS[0], 0.0), t),
    ]
    up = ca.vertcat(*[PERIOD * speed for speed in SPEEDS])
    thrown = up + 0.5 * ca.vertcat(0.3 * x[0] + 0.2 * x[1], 0.3 * x[1])
    rows = [
        ("both", "a down", x[0], x, False),
        ("both", "b down", x[1], x, False),
        ("a down", "both", x[1], thrown, at_entry),
        ("b down", "both", x[0], thrown, at_entry),
    ]
    transitions = [
        Transition.from_expressions(source, target, x, guard, reset, at_entry=entry)
        for source, target, guard, reset, entry in rows
    ]
    return HybridSystem(domains, transitions)


OFFSETS = [0.0, 1e-16, -1e-16, 1e-13, -1e-13, 1e-11, -1e-11, 1e-9, 1e-3, -1e-3]


@pytest.mark.parametrize("compiler", ["auto", "none"])
@pytest.mark.parametrize("offset", OFFSETS)
def test_the_second_landing_is_found(offset: float, compiler: str, monkeypatch: pytest.MonkeyPatch) -> None:
    if compiler == "none":
        monkeypatch.setenv("AMBLE_COMPILER", "none")
    start = np.array([PERIOD * SPEEDS[0], PERIOD * SPEEDS[1] + offset])
    trace = simulate(falling(at_entry=True), start, 3, 1e-10)
    assert trace.completed, trace.ended
    assert len(trace.events) == 6
    late = max(0.0, offset) / SPEEDS[1]
    assert trace.events[1].time == pytest.approx(PERIOD + late, abs=1e-9)


def test_without_the_rule_a_landing_at_once_is_missed() -> None:
    trace = simulate(falling(at_entry=False), np.array([PERIOD * SPEEDS[0], PERIOD * SPEEDS[1]]), 1, time_limit=1.0)
    assert not trace.completed


def test_short_stays_between_landings_are_no_accumulation() -> None:
    """Stays that shrink from cycle to cycle, as a motion that settles on landing at once makes them."""
    start = np.array([PERIOD * SPEEDS[0], PERIOD * SPEEDS[1] + 1e-7])
    trace = simulate(falling(at_entry=True), start, 40, 1e-12)
    assert trace.completed, trace.ended


def test_an_orbit_that_lands_at_once_has_a_fixed_point_and_a_derivative() -> None:
    """Its map is that of the order taken; both heights are thrown to the same place, so nothing is left of a change."""
    system = falling(at_entry=True)
    start = np.array([PERIOD * SPEEDS[0], PERIOD * SPEEDS[1]])
    found = fixed_point(system, start)
    np.testing.assert_allclose(found.state, start, atol=1e-9)
    assert multipliers(system, found.state).radius < 1e-6
