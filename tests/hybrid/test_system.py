"""The hybrid system validates itself: every fault of the graph and of the shapes is named on construction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.hybrid import Domain, HybridSystem, Invariant, Transition
from amble.hybrid.system import numeric
from amble.types import frozen

x = ca.SX.sym("x", 2)


def domain(name: str, size: int = 2) -> Domain:
    state = ca.SX.sym("x", size)
    return Domain.from_expressions(name, state, -state, signals={"first": state[0]}, admissibility=state[0])


def transition(source: str, target: str) -> Transition:
    return Transition.from_expressions(source, target, x, x[0], ca.vertcat(x[1], x[0]))


@pytest.fixture
def bouncing() -> HybridSystem:
    return HybridSystem([domain("up"), domain("down")], [transition("up", "down"), transition("down", "up")])


def test_a_cycle_in_order(bouncing: HybridSystem) -> None:
    assert [(d.name, t.name) for d, t in bouncing.cycle()] == [("up", "up->down"), ("down", "down->up")]
    assert bouncing.state_size == 2
    assert bouncing.state_names == ("x0", "x1")
    assert bouncing.domain("down").state_size == 2
    assert [t.target for t in bouncing.leaving("up")] == ["down"]


def test_expressions_become_functions_of_clock_state_and_parameters() -> None:
    clock = ca.SX.sym("t")
    built = Domain.from_expressions("swing", x, ca.vertcat(x[1], clock), clock, {"sum": x[0] + x[1]}, x[0] - 1.0)
    assert built.field.name_in() == ["t", "x", "p"]
    np.testing.assert_array_equal(numeric(built.field(3.0, [1.0, 2.0], [])), [2.0, 3.0])
    assert built.signals is not None
    assert built.admissibility is not None
    assert float(built.signals(0.0, [1.0, 2.0], [])) == 3.0
    assert float(built.admissibility(0.0, [1.0, 2.0], [])) == 0.0
    assert Domain.from_expressions("plain", x, x).signals is None


def test_unknown_names_say_what_is_known(bouncing: HybridSystem) -> None:
    with pytest.raises(UnknownNameError, match="unknown domain 'sideways'; known: up, down"):
        bouncing.domain("sideways")


def test_a_graph_that_branches_has_no_cycle() -> None:
    system = HybridSystem(
        [domain("a"), domain("b")], [transition("a", "b"), transition("a", "a"), transition("b", "a")]
    )
    with pytest.raises(InputError, match="not one cycle: domain 'a' has 2 successors"):
        system.cycle()


def test_a_cycle_that_never_returns_to_the_first_domain() -> None:
    system = HybridSystem([domain("a"), domain("b")], [transition("a", "b"), transition("b", "b")])
    with pytest.raises(InputError, match="not one cycle"):
        system.cycle()


AROUND = [transition("a", "a")]
FAULTS: list[tuple[Callable[[], HybridSystem], str]] = [
    (lambda: HybridSystem([], []), "at least one domain"),
    (lambda: HybridSystem([domain("a"), domain("a")], AROUND), "names occur twice"),
    (lambda: HybridSystem([domain("a")], []), "no transition that leaves it"),
    (lambda: HybridSystem([domain("a"), domain("b")], [*AROUND, transition("b", "a")]), "'b' cannot be reached"),
    (lambda: HybridSystem([domain("a")], [transition("a", "b")]), "unknown domain 'b'; known: a"),
    (lambda: HybridSystem([domain("a")], [*AROUND, transition("b", "a")]), "unknown domain 'b'; known: a"),
    (lambda: HybridSystem([domain("a")], [replace(AROUND[0], direction=0)]), "is 0; known: -1, \\+1"),
    (lambda: HybridSystem([domain("a")], [replace(AROUND[0], dead_time=-0.1)]), "below 0"),
    (lambda: HybridSystem([domain("a")], [replace(AROUND[0], dead_time=float("nan"))]), "below 0"),
    (lambda: HybridSystem([domain("a", 3)], AROUND), "maps 2 states to 1 values, not 3 to 1"),
    (lambda: HybridSystem([domain("a"), domain("b", 3)], AROUND), "field of domain 'b' maps 3 states"),
    (lambda: HybridSystem([replace(domain("a"), parameters=frozen([1.0]))], AROUND), "has 1 parameters, not 0"),
    (
        lambda: HybridSystem([domain("a")], [replace(AROUND[0], reset=AROUND[0].guard)]),
        "reset of 'a->a' maps 2 states to 1 values",
    ),
    (
        lambda: HybridSystem([domain("a")], [replace(AROUND[0], guard=AROUND[0].reset)]),
        "guard of 'a->a' maps 2 states to 2 values",
    ),
    (
        lambda: HybridSystem([replace(domain("a"), signals=domain("b", 3).field)], AROUND),
        "signals of domain 'a' takes 3 states, not 2",
    ),
    (
        lambda: HybridSystem([replace(domain("a"), jacobian=domain("b", 3).field)], AROUND),
        "jacobian of domain 'a' takes 3 states, not 2",
    ),
    (
        lambda: HybridSystem([replace(domain("a"), admissibility=domain("a").field)], AROUND),
        "margin of domain 'a' maps 2 states to 2 values",
    ),
    (
        lambda: HybridSystem([replace(domain("a"), field=ca.Function("f", [x], [x]))], AROUND),
        "takes 1 arguments, not",
    ),
    (lambda: HybridSystem([domain("a")], AROUND, state_names=["one"]), "1 state names for 2 states"),
    (lambda: HybridSystem([domain("a")], AROUND, state_names=["one", "one"]), "the state name 'one' occurs twice"),
]


@pytest.mark.parametrize(("build", "says"), FAULTS, ids=[says for _, says in FAULTS])
def test_faults(build: Callable[[], HybridSystem], says: str) -> None:
    with pytest.raises(InputError, match=says):
        build()


m = ca.MX.sym("m", 2)
ODD: list[tuple[Callable[[], object], str]] = [
    (lambda: Domain.from_expressions("left", m, m), "the state is no symbol of kind SX .* but of kind MX"),
    (lambda: Domain.from_expressions("left", x, m), "rate of domain 'left' is no expression of kind SX but of kind MX"),
    (lambda: Domain.from_expressions("left", x, "x"), "rate of domain 'left' is no expression of kind SX but a str"),
    (lambda: Domain.from_expressions("left", x + 1, x), "the state is no symbol of kind SX"),
    (lambda: Domain.from_expressions("left", x, x, clock=ca.SX.sym("t", 2)), "clock is a scalar symbol, not one of 2"),
    (lambda: Domain.from_expressions("left", x, x, clock=x[0]), "occur twice"),
    (lambda: Domain.from_expressions("left", x, x * ca.SX.sym("k")), "holds the symbol 'k', which is neither"),
    (lambda: Domain.from_expressions("left", x, x, signals={"left foot": x}), "cannot be called 'left foot'"),
    (lambda: Domain.from_expressions("left", x, x, signals={"jac": x}), "cannot be called 'jac'"),
    (lambda: Domain.from_expressions("left", x, x, admissibility=m[0]), "margin of domain 'left' is no expression"),
    (lambda: Transition.from_expressions("a", "b", x, m[0], x), "guard of 'a->b' is no expression of kind SX"),
    (lambda: Transition.from_expressions("a", "b", x, x[0], m), "reset of 'a->b' is no expression of kind SX"),
    (lambda: Transition.from_expressions("a", "b", m, x[0], x), "the state is no symbol"),
    (lambda: Transition.from_expressions("a", "b", x, ca.SX.sym("level"), x), "holds the symbol 'level'"),
]


@pytest.mark.parametrize(("build", "says"), ODD, ids=[says for _, says in ODD])
def test_what_is_no_expression_is_one_sentence(build: Callable[[], object], says: str) -> None:
    with pytest.raises(InputError, match=says) as caught:
        build()
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("name", ["left stance", "links hüfte", "a__b", "1", "null", "f/r", "jac"])
def test_a_domain_may_have_any_name(name: str) -> None:
    built = Domain.from_expressions(name, x, ca.vertcat(x[1], -9.81))
    step = Transition.from_expressions(name, name, x, x[0], x)
    system = HybridSystem([built], [step])
    assert system.cycle()[0][1].name == f"{name}->{name}"


def test_expressions_take_parameters() -> None:
    p, t = ca.SX.sym("p", 2), ca.SX.sym("t")
    built = Domain.from_expressions(
        "left", x, p[0] * x, signals={"sum": p[0] + p[1]}, admissibility=p[1], parameters=p, values=[3.0, 4.0]
    )
    step = Transition.from_expressions("left", "left", x, x[0] - p[1] * t, p[0] * x, clock=t, parameters=p)
    system = HybridSystem([built], [step])
    np.testing.assert_array_equal(numeric(built.field(0.0, [1.0, 2.0], built.parameters)), [3.0, 6.0])
    assert float(system.transitions[0].guard(0.5, [1.0, 2.0], built.parameters)) == -1.0
    np.testing.assert_array_equal(numeric(system.transitions[0].reset(0.0, [1.0, 2.0], built.parameters)), [3.0, 6.0])
    with pytest.raises(InputError, match="has 1 parameters, not 2"):
        HybridSystem([Domain.from_expressions("left", x, x, parameters=p, values=[3.0])], [step])


def test_guards_resets_and_domains_share_their_parameters() -> None:
    p = ca.SX.sym("p", 2)
    with pytest.raises(InputError, match="guard of 'a->a' takes 2 parameters, and domain 'a' has 0"):
        HybridSystem([domain("a")], [Transition.from_expressions("a", "a", x, x[0] - p[1], x, parameters=p)])


@pytest.mark.parametrize("bound", [0.0, -1.0, float("nan")])
def test_a_slope_bound_is_positive(bound: float) -> None:
    with pytest.raises(InputError, match="slope bound of 'a->a'"):
        HybridSystem([domain("a")], [replace(AROUND[0], slope_bound=bound)])


def test_an_invariant_is_a_function_of_the_state() -> None:
    wrong = Invariant("energy", ca.Function("e", [x], [x]))
    with pytest.raises(InputError, match="invariant 'energy' is no function of 2 states with one value"):
        HybridSystem([domain("a")], AROUND, invariants=[wrong])
