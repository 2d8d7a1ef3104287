"""The hybrid system validates itself: every fault of the graph and of the shapes is named on construction."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.hybrid import Domain, HybridSystem, Transition
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
]


@pytest.mark.parametrize(("build", "says"), FAULTS, ids=[says for _, says in FAULTS])
def test_faults(build: Callable[[], HybridSystem], says: str) -> None:
    with pytest.raises(InputError, match=says):
        build()
