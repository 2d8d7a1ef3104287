"""Functions that may throw are evaluated where their failure is caught, not in C code, which it would end."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiled
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import simulate
from amble.simulation.bound import bind
from amble.simulation.faults import may_throw
from amble.types import frozen

ARGUMENTS = ["t", "x", "p"]


def square_root() -> ca.Function:
    """Newton's solution z of z^2 = x, which fails where x is negative."""
    z, x = ca.SX.sym("z"), ca.SX.sym("x")
    return ca.rootfinder("root", "newton", {"x": z, "p": x, "g": z**2 - x}, {"max_iter": 20})


def wrapped(rate: ca.MX, t: ca.MX, x: ca.MX, p: ca.MX) -> ca.Function:
    return ca.Function("field", [t, x, p], [rate], ARGUMENTS, ["rate"])


def examples() -> dict[str, tuple[ca.Function, bool]]:
    t, x, p = ca.MX.sym("t"), ca.MX.sym("x"), ca.MX.sym("p", 0)
    s = [ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("p", 0)]
    arithmetic = ca.Function("arithmetic", s, [s[1] ** 2], ARGUMENTS, ["rate"])
    rooted = wrapped(square_root()(1.0, x), t, x, p)
    return {
        "arithmetic": (arithmetic, False),
        "compiled": (compiled(arithmetic), False),
        "calls arithmetic": (wrapped(2 * arithmetic(t, x, p), t, x, p), False),
        "solver": (rooted, True),
        "calls one that calls a solver": (wrapped(rooted(t, x, p), t, x, p), True),
        "assertion": (wrapped(x.attachAssert(x > 0, "negative"), t, x, p), True),
    }


@pytest.mark.parametrize("name", examples())
def test_what_may_throw(name: str) -> None:
    function, throws = examples()[name]
    assert may_throw(function) == throws


@pytest.mark.filterwarnings("ignore")
def test_a_failed_sample_is_not_a_number() -> None:
    bound = bind(examples()["solver"][0], np.zeros(0))
    (found,) = bound.along(np.zeros(3), np.array([[4.0], [-1.0], [9.0]]))
    np.testing.assert_allclose(found.ravel(), [2.0, np.nan, 3.0], rtol=1e-9)


@pytest.mark.parametrize("name", ["solver", "assertion"])
def test_a_motion_into_a_failure_ends_there(name: str) -> None:
    """x falls at unit speed plus what the function gives, until the function fails below zero."""
    t, x, p = ca.MX.sym("t"), ca.MX.sym("x"), ca.MX.sym("p", 0)
    function = examples()[name][0]
    field = wrapped(-1.0 - function(t, x, p), t, x, p)
    guard = ca.Function("guard", [t, x, p], [x + 1.0], ARGUMENTS, ["guard"])
    reset = ca.Function("reset", [t, x, p], [ca.MX(1.0)], ARGUMENTS, ["state"])
    system = HybridSystem(
        [Domain(name="fall", field=field, parameters=frozen([]))],
        [Transition(source="fall", target="fall", guard=guard, reset=reset, direction=-1)],
        (),
        ("x",),
    )
    trace = simulate(system, np.array([0.5]), 1)
    assert trace.ended.startswith("the motion cannot go on")
