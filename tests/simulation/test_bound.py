from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiled
from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import bound as bound_module
from amble.simulation import simulate
from amble.simulation.bound import bind, may_throw
from amble.types import frozen

ARGUMENTS = ["t", "x", "p"]


def sparse_function() -> ca.Function:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 3), ca.SX.sym("p", 2)
    first = ca.vertcat(ca.SX(1, 1), p[0] * x[1], ca.SX(1, 1), t)  # structural zeros
    return ca.Function("sparse", [t, x, p], [first, x * p[1]], ["t", "x", "p"], ["first", "second"])


def test_a_bound_function_gives_what_the_function_gives() -> None:
    function, parameters = sparse_function(), np.array([2.0, 3.0])
    assert not function.sparsity_out(0).is_dense()
    state = np.array([1.0, -1.0, 0.5])
    results = bind(function, parameters)(0.7, state)
    for result, expected in zip(results, function(0.7, state, parameters), strict=True):
        assert np.array_equal(result, np.asarray(ca.DM.full(expected)).ravel())


def test_results_are_copies() -> None:
    bound = bind(sparse_function(), np.array([2.0, 3.0]))
    first = bound(0.0, np.ones(3))[1]
    bound(0.0, np.zeros(3))
    assert first == pytest.approx(3.0 * np.ones(3))


def test_many_samples_are_the_single_ones() -> None:
    bound = bind(sparse_function(), np.array([2.0, 3.0]))
    clocks, states = np.linspace(0, 1, 5), np.random.default_rng(1).normal(size=(5, 3))
    first, second = bound.along(clocks, states)
    assert (first.shape, second.shape) == ((5, 4), (5, 3))
    for row in range(5):
        single = bound(clocks[row], states[row])
        assert np.array_equal(first[row], single[0])
        assert np.array_equal(second[row], single[1])


def test_the_native_samples_are_those_of_python(monkeypatch: pytest.MonkeyPatch) -> None:
    bound = bind(sparse_function(), np.array([2.0, 3.0]))
    clocks, states = np.linspace(0, 1, 5), np.random.default_rng(2).normal(size=(5, 3))
    native = bound.along(clocks, states)
    monkeypatch.setattr(bound_module, "load", lambda _: None)
    for ours, theirs in zip(native, bound.along(clocks, states), strict=True):
        assert np.array_equal(ours, theirs)


def test_samples_of_any_type_and_layout() -> None:
    bound = bind(sparse_function(), np.array([2.0, 3.0]))
    clocks, states = np.arange(4), np.arange(12).reshape(4, 3)
    expected = bound.along(clocks.astype(float), states.astype(float))
    backwards = np.asfortranarray(np.repeat(states, 2, axis=1).astype(np.float32))[:, ::2]
    for given in (states, backwards):
        for ours, theirs in zip(bound.along(clocks, given), expected, strict=True):
            assert np.array_equal(ours, theirs)


@pytest.mark.parametrize("shape", [(4, 2), (4, 4), (3, 3), (12,)])
def test_samples_of_another_shape_are_refused(shape: tuple[int, ...]) -> None:
    with pytest.raises(InputError, match="samples have clocks of shape"):
        bind(sparse_function(), np.array([2.0, 3.0])).along(np.zeros(4), np.zeros(shape))


@pytest.mark.parametrize("count", [0, 1, 3])
def test_another_number_of_parameters_is_refused(count: int) -> None:
    with pytest.raises(InputError, match=f"'sparse' takes 2 parameters, not {count}"):
        bind(sparse_function(), np.zeros(count))


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
