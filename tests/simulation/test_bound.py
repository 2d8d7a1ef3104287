from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.simulation.bound import bind


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
