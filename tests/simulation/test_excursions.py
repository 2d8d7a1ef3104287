"""Guards that pass zero and return: none longer than ``max_step`` is missed, none at all with a bound on the slope."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from amble.codegen.compiler import compiler
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import flow, interpreted, native, simulate
from amble.simulation.flow import Arc, FlowDefinition
from amble.simulation.prepared import event_functions

WAYS = [
    pytest.param(native.prepare, id="native", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
    pytest.param(interpreted.prepare, id="scipy"),
]
Way = Callable[[FlowDefinition], flow.Flow | None]


def run(way: Way, guard: Callable[[ca.SX], ca.SX], direction: int, max_step: float, bound: float = np.inf) -> Arc:
    """x = clock from 0 on, for a time of 1: steps of the integrator as long as they can be."""
    x = ca.SX.sym("x", 1)
    domain = Domain.from_expressions("on", x, ca.SX(1))
    leaving = Transition.from_expressions("on", "on", x, guard(x), x, direction, slope_bound=bound)
    prepared = way(FlowDefinition(domain.field, domain.parameters, event_functions(domain, (leaving,))))
    assert prepared is not None
    return prepared(np.zeros(1), 1e-10, 1.0, 2, max_step)


@pytest.mark.parametrize("gap", [1.0, 0.05, 0.01, 1e-3, 1e-5])
def test_a_landing_soon_after_a_rise(gap: float) -> None:
    """A guard that rises through zero at 1 and falls through it at 1 + gap; the field is a polynomial."""
    x = ca.SX.sym("x", 2)
    height = (x[0] - 1) * (x[0] - 1 - gap) * (x[0] - 3)
    start = -(1 + gap) * 3.0
    fly = Domain.from_expressions("fly", x, ca.vertcat(1, ca.jacobian(height, x[0])))
    land = Transition.from_expressions("fly", "fly", x, x[1], ca.vertcat(0, start), direction=-1)
    trace = simulate(HybridSystem([fly], [land]), np.array([0.0, start]), 1)
    assert trace.completed
    # the integrator's error of 1e-8 moves a root of slope 2 gap by 5e-9 / gap
    assert trace.time[-1] == pytest.approx(1 + gap, abs=min(1e-8 / gap, gap))


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("below", [1e-3, 1e-6, 1e-8, 1e-10])
def test_a_ball_on_an_oscillating_table_is_met_at_the_first_top(below: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    turn, late = random.uniform(0.5, 5.0), random.uniform(0.2, 1.0)
    x = ca.SX.sym("x", 2)
    table = Domain.from_expressions("table", x, turn * ca.vertcat(x[1], -x[0]))
    meet = Transition.from_expressions("table", "table", x, x[0] - (1 - below), x, +1)
    trace = simulate(HybridSystem([table], [meet]), np.array([-np.sin(late), np.cos(late)]), 1, tolerance=1e-13)
    first = (late + np.arcsin(1 - below)) / turn
    # roundoff 1e-15 of the height moves the time by 1e-15 / slope, slope = sqrt(2 below); the integrator adds 1e-12
    assert trace.time[-1] == pytest.approx(first, abs=1e-11 / np.sqrt(below))


@pytest.mark.parametrize("below", [1e-6, 1e-8, 1e-10])
def test_the_first_top_is_met_with_the_defaults(below: float) -> None:
    """Its level 1e-8 below the top, the ball was met at the second top, at 7.854 instead of 1.571 s."""
    x = ca.SX.sym("x", 2)
    table = Domain.from_expressions("table", x, ca.vertcat(x[1], -x[0]))
    meet = Transition.from_expressions("table", "table", x, x[0] - (1 - below), x, +1)
    trace = simulate(HybridSystem([table], [meet]), np.array([0.0, 1.0]), 1)
    # a height that is wrong by e crosses 2 sqrt(2 e) about the top, and the integrator's tolerance is 1e-8
    assert trace.time[-1] == pytest.approx(np.pi / 2, abs=np.sqrt(2 * below) + 2 * np.sqrt(2e-8))


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(8))
def test_no_excursion_longer_than_the_longest_step_is_missed(way: Way, seed: int) -> None:
    """Needles that no look farther away sees: flat, and of either direction."""
    random = np.random.default_rng(seed)
    place, half = random.uniform(0.1, 0.9), 10.0 ** random.uniform(-2.5, -1.5)
    sharp = random.integers(2, 6)
    direction = int(random.choice([-1, 1]))

    def needle(x: ca.SX) -> ca.SX:
        return direction * (ca.exp(-(((x - place) / half) ** (2 * int(sharp))) * np.log(2)) - 0.5)

    arc = run(way, needle, direction, 1.99 * half)
    assert arc.fired == 0
    assert arc.clock[-1] == pytest.approx(place - half, abs=1e-12)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(4))
def test_with_a_slope_bound_none_is_missed(way: Way, seed: int) -> None:
    random = np.random.default_rng(seed)
    place, half = random.uniform(0.1, 0.9), 10.0 ** random.uniform(-4, -3)

    def needle(x: ca.SX) -> ca.SX:
        return ca.exp(-(((x - place) / half) ** 2) * np.log(2)) - 0.5

    steepest = np.sqrt(2 * np.log(2) / np.e) / half
    assert run(way, needle, +1, 0.5).fired is None  # else this test would show nothing
    arc = run(way, needle, +1, 0.5, 1.01 * steepest)
    assert arc.fired == 0
    assert arc.clock[-1] == pytest.approx(place - half, abs=1e-12)


@pytest.mark.parametrize("way", WAYS)
def test_a_guard_steeper_than_its_bound_is_named(way: Way) -> None:
    arc = run(way, lambda x: 2 * x - 1, +1, 0.1, 1.0)
    assert (arc.fired, arc.ended) == (None, flow.STEEP)
    assert run(way, lambda x: 2 * x - 1, +1, 0.1, 2.0).clock[-1] == pytest.approx(0.5, abs=1e-14)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(10))
@pytest.mark.parametrize("power", [1, 2, 3, 4])
def test_a_foot_that_lifts_softly_does_not_land_at_once(way: Way, power: int, seed: int) -> None:
    """Height t^power (t_end - t), written so that it is roundoff about zero at first."""
    random = np.random.default_rng(seed)
    length, end = random.uniform(0.3, 2.0), random.uniform(0.3, 0.9)

    def height(x: ca.SX) -> ca.SX:
        return (length + x**power * (end - x)) - length

    arc = run(way, height, -1, 1e-3)
    assert arc.fired == 0
    assert arc.clock[-1] == pytest.approx(end, abs=1e-14 / end**power)


@pytest.mark.parametrize("way", WAYS)
def test_the_first_of_two_excursions_counts(way: Way) -> None:
    arc = run(way, lambda x: (x - 0.2) * (x - 0.2001) * (x - 0.7) * (x - 0.7001), -1, 0.01)
    assert arc.clock[-1] == pytest.approx(0.2, abs=1e-10)


@pytest.mark.parametrize("way", WAYS)
@pytest.mark.parametrize("seed", range(10))
def test_random_polynomials_fire_at_their_first_root(way: Way, seed: int) -> None:
    """Six roots in disorder; the first at which the guard falls is the event."""
    random = np.random.default_rng(seed)
    roots = np.sort(random.uniform(0.0, 1.0, 6))
    arc = run(way, lambda x: ca.mtimes([x - float(root) for root in roots]), -1, 1e-2)
    assert arc.clock[-1] == pytest.approx(roots[0], abs=1e-9)
    arc = run(way, lambda x: ca.mtimes([x - float(root) for root in roots]), +1, 1e-2)
    assert arc.clock[-1] == pytest.approx(roots[1], abs=1e-9)
