"""The flow through one domain: both implementations, the same rules."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiled
from amble.codegen.compiler import compiler
from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import flow, interpreted, native, prepared
from amble.simulation.flow import Arc, Flow, FlowDefinition
from amble.simulation.simulate import simulate
from tests.hybrids import GRAVITY, blow_up, bouncing_ball, clockwork, two_phases

Preparation = Callable[[HybridSystem, str], Flow]


def definition(system: HybridSystem, name: str) -> FlowDefinition:
    domain = system.domain(name)
    events = prepared.event_functions(domain, system.leaving(name))
    return FlowDefinition(
        domain.field, domain.parameters, events, tuple(prepared.margins_of(domain)), domain.breakpoints
    )


def in_native_code(system: HybridSystem, name: str) -> Flow:
    prepared = native.prepare(definition(system, name))
    assert prepared is not None
    return prepared


def with_scipy(system: HybridSystem, name: str) -> Flow:
    return interpreted.prepare(definition(system, name))


WAYS = [
    pytest.param(in_native_code, id="native", marks=pytest.mark.skipif(compiler() is None, reason="no C compiler")),
    pytest.param(with_scipy, id="scipy"),
]


def run(
    prepare: Preparation, system: HybridSystem, start: list[float], time_limit: float = 20.0, max_step: float = 0.02
) -> Arc:
    return prepare(system, system.domains[0].name)(np.array(start), 1e-10, time_limit, 5, max_step)


@pytest.mark.parametrize("prepare", WAYS)
@pytest.mark.parametrize("height", [0.0, 1e-17, -1e-17, -1e-6])
def test_a_foot_that_has_just_lifted_lands_where_it_should(prepare: Preparation, height: float) -> None:
    arc = run(prepare, bouncing_ball(), [height, 2.0])
    landing = (2.0 + np.sqrt(4.0 + 2 * GRAVITY * height)) / GRAVITY
    assert arc.fired == 0
    assert arc.clock[-1] == pytest.approx(landing, abs=1e-12)  # polynomial motion: only roundoff remains
    assert arc.state[-1, 0] == pytest.approx(0.0, abs=1e-14)


@pytest.mark.parametrize("prepare", WAYS)
@pytest.mark.parametrize(
    ("guard", "start", "expected"),
    [
        (("sine", +1, 0.0), 0.0, 2 * np.pi),  # zero at the start and rising: only the next rise counts
        (("sine", -1, 0.0), 0.0, np.pi),
        (("sine", +1, 0.0), 1e-13, 2 * np.pi),
        (("sine", +1, 0.0), -1e-13, 2 * np.pi),  # within roundoff of the start
        (("sine", +1, 0.0), -1e-3, 0.0),  # clearly before it
        (("sine", +1, 0.1), -1e-3, 2 * np.pi),  # unless the guard sleeps until 0.1
        (("sine", -1, 0.0), 3.5, 3 * np.pi),  # starts on the far side and has to come back first
        (("sine", -1, 4.0), 0.0, 3 * np.pi),
    ],
)
def test_a_guard_fires_where_it_crosses(
    prepare: Preparation, guard: tuple[str, int, float], start: float, expected: float
) -> None:
    arc = run(prepare, clockwork(guard), [start])
    assert arc.fired == 0
    assert arc.state[-1, 0] == pytest.approx(expected, abs=1e-11)  # events are located to 1e-10 s at least


@pytest.mark.parametrize("prepare", WAYS)
def test_the_first_of_several_guards_fires(prepare: Preparation) -> None:
    arc = run(prepare, clockwork(("sine", -1, 0.0), ("line", +1, 0.0)), [0.0])
    assert arc.fired == 1
    assert arc.clock[-1] == pytest.approx(1.0, abs=1e-12)


@pytest.mark.parametrize("prepare", WAYS)
def test_a_guard_that_is_never_reached_ends_the_passage(prepare: Preparation) -> None:
    arc = run(prepare, clockwork(("line", -1, 0.0)), [0.0], time_limit=3.0)
    assert (arc.fired, arc.ended) == (None, flow.TOO_LONG)
    assert arc.clock[-1] == 3.0
    assert arc.state[:, 0] == pytest.approx(arc.clock, abs=1e-13)


@pytest.mark.parametrize("prepare", WAYS)
def test_a_motion_that_grows_without_bound_ends_with_a_reason(prepare: Preparation) -> None:
    arc = run(prepare, blow_up(), [1.0])
    assert arc.fired is None
    assert arc.ended == flow.STUCK
    assert arc.clock[-1] == pytest.approx(1.0, abs=1e-6)
    assert np.all(np.isfinite(arc.state))


@pytest.mark.parametrize("prepare", WAYS)
def test_a_motion_too_stiff_to_follow_ends_with_a_reason(prepare: Preparation, monkeypatch: pytest.MonkeyPatch) -> None:
    """A rate of -1e7 leaves steps of some 1e-7 s: ten million of them a second, in memory without end."""
    monkeypatch.setattr(interpreted, "MOST_STEPS", 300)  # scipy's take a millisecond each
    x = ca.SX.sym("x", 1)
    domain = Domain.from_expressions("stiff", x, -1e7 * x)
    system = HybridSystem([domain], [Transition.from_expressions("stiff", "stiff", x, x + 1, x)])
    arc = run(prepare, system, [1.0])
    assert (arc.fired, arc.ended) == (None, flow.STUCK)
    assert arc.steps <= flow.MOST_STEPS
    assert 0.0 < arc.clock[-1] < 0.1


@pytest.mark.parametrize("prepare", WAYS)
def test_a_guard_that_is_not_a_number_ends_the_passage(prepare: Preparation) -> None:
    assert run(prepare, clockwork(("nan", -1, 0.0)), [0.0]).ended == flow.STUCK


@pytest.mark.parametrize("prepare", WAYS)
def test_a_field_that_is_not_a_number_ends_the_passage(prepare: Preparation) -> None:
    x = ca.SX.sym("x", 1)
    domain = Domain.from_expressions("root", x, -1 - ca.sqrt(x))
    system = HybridSystem([domain], [Transition.from_expressions("root", "root", x, x + 5, x)])
    assert run(prepare, system, [0.5]).ended == flow.STUCK


@pytest.mark.parametrize("prepare", WAYS)
def test_a_fall_is_told_from_a_transition(prepare: Preparation) -> None:
    x = ca.SX.sym("x", 1)
    domain = Domain.from_expressions("fading", x, -x, admissibility=x - 0.5)
    system = HybridSystem([domain], [Transition.from_expressions("fading", "fading", x, x - 0.25, x)])
    arc = run(prepare, system, [1.0])
    assert (arc.fired, arc.ended) == (None, flow.LEFT_DOMAIN)
    assert arc.clock[-1] == pytest.approx(np.log(2), abs=1e-9)  # tolerance 1e-10


@pytest.mark.skipif(compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("tolerance", [1e-5, 1e-8, 1e-11])
def test_both_ways_take_the_same_steps(tolerance: float) -> None:
    start = np.array([0.0, 1.0, 0.2])
    first, second = (
        prepare(two_phases(), "push")(start, tolerance, 20.0, 9, 0.02) for prepare in (in_native_code, with_scipy)
    )
    assert first.steps == second.steps
    assert first.fired == second.fired == 0
    # the same operations in another order: roundoff, amplified by some steps
    assert first.state == pytest.approx(second.state, abs=1e-13)
    assert first.clock == pytest.approx(second.clock, abs=1e-13)


@pytest.mark.parametrize("prepare", WAYS)
def test_the_error_follows_the_tolerance(prepare: Preparation) -> None:
    x = ca.SX.sym("x", 2)
    domain = Domain.from_expressions("swing", x, ca.vertcat(x[1], -x[0]))
    system = HybridSystem([domain], [Transition.from_expressions("swing", "swing", x, x[1], x, +1)])
    tolerances = np.logspace(-5, -11, 7)
    errors, steps = [], []
    for tolerance in tolerances:
        arc = prepare(system, "swing")(np.array([1.0, 0.0]), tolerance, 20.0, 20, 0.02)
        exact = np.column_stack([np.cos(arc.clock), -np.sin(arc.clock)])
        errors.append(max(np.abs(arc.state - exact).max(), abs(arc.clock[-1] - np.pi)))
        steps.append(arc.steps)
    assert np.all(errors < 30 * tolerances)  # global error over half a turn and a few steps, dense output included
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert order > 6.5  # dense output of order 7


@pytest.mark.parametrize("prepare", WAYS)
def test_a_step_ends_at_a_kink(prepare: Preparation) -> None:
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 1)
    leaving = Transition.from_expressions("bent", "bent", x, x - 3, x, +1)
    bent = Domain.from_expressions("bent", x, 1 + 10 * ca.fabs(t - 0.3), clock=t)
    blind, warned = (
        run(prepare, HybridSystem([domain], [leaving]), [0.0])
        for domain in (bent, dataclasses.replace(bent, breakpoints=(0.3, 5.0)))
    )
    # x = t + 5 (0.09 - (0.3 - t)^2) up to the breakpoint, then 0.75 + s + 5 s^2 with s = t - 0.3
    exact = 0.3 + (-1 + np.sqrt(1 + 20 * 2.25)) / 10
    assert warned.clock[-1] == pytest.approx(exact, abs=1e-13)  # quadratic pieces are integrated exactly
    assert blind.clock[-1] == pytest.approx(exact, abs=1e-8)
    assert warned.steps < blind.steps


@pytest.mark.parametrize("breakpoints", [(0.0,), (-1.0,), (0.2, 0.2), (0.3, 0.1), (np.nan,)])
def test_kinks_are_positive_and_ascending(breakpoints: tuple[float, ...]) -> None:
    system = bouncing_ball()
    with pytest.raises(InputError, match="breakpoints of domain 'flight' are not positive and ascending"):
        HybridSystem([dataclasses.replace(system.domains[0], breakpoints=breakpoints)], system.transitions)


@pytest.mark.parametrize("prepare", WAYS)
def test_compiled_wrapped_and_sparse_functions_move_alike(prepare: Preparation) -> None:
    t, x, p = ca.MX.sym("t"), ca.MX.sym("x", 3), ca.MX.sym("p", 2)
    system = two_phases()
    domain, leaving = system.domain("push"), system.leaving("push")
    wrapped = ca.Function(
        "wrapped",
        [t, x, p],
        [ca.sparsify(ca.DM([[0, 1, 0], [1, 0, 0], [0, 0, 1]])) @ compiled(domain.field)(t, x, p)[[1, 0, 2]]],
    )
    other = HybridSystem(
        [Domain(name="push", field=wrapped, parameters=domain.parameters), system.domains[1]], system.transitions
    )
    start = [0.0, 1.0, 0.2]
    assert leaving
    assert run(prepare, other, start).state == pytest.approx(run(prepare, system, start).state, abs=1e-13)


def test_without_a_compiler_scipy_does_the_work(monkeypatch: pytest.MonkeyPatch) -> None:
    expected = simulate(bouncing_ball(), np.array([0.0, 1.0]), 3)
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    assert isinstance(prepared.prepare(bouncing_ball(), "flight"), interpreted.InterpretedFlow)
    found = simulate(bouncing_ball(), np.array([0.0, 1.0]), 3)
    assert found.state == pytest.approx(expected.state, abs=1e-13)
