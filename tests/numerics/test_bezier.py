"""Bezier curves against their definition, against casadi's derivatives, and the laws of elevation and fitting."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from amble.errors import InputError
from amble.numerics.bezier import bernstein, bernstein_derivatives, bezier, elevate, evaluate, fit
from amble.types import Matrix

ORDERS = [0, 1, 2, 3, 4, 5, 8, 14]
PHASES = np.linspace(0.0, 1.0, 33)

# Coefficients are of size one and the basis is positive and sums to one, so rounding stays near 1e-16 for values and
# near order^2 times that for second derivatives.
TOLERANCE = 1e-12


def coefficients(order: int, curves: int = 3) -> Matrix:
    return np.random.default_rng(order).normal(size=(curves, order + 1))


@pytest.mark.parametrize("order", ORDERS)
def test_basis_is_a_partition_of_unity(order: int) -> None:
    basis, first, second = bernstein_derivatives(order, PHASES)
    np.testing.assert_allclose(sum(basis), 1.0, atol=TOLERANCE)
    np.testing.assert_allclose(sum(first), 0.0, atol=TOLERANCE * (1 + order))
    np.testing.assert_allclose(sum(second), 0.0, atol=TOLERANCE * (1 + order**2))
    assert all(np.all(np.asarray(polynomial) >= 0.0) for polynomial in basis)


@pytest.mark.parametrize("order", ORDERS)
def test_curve_equals_repeated_interpolation(order: int) -> None:
    """De Casteljau's algorithm needs no binomial coefficient."""
    points = coefficients(order)
    expected = np.array([points.copy() for _ in PHASES])
    for _ in range(order):
        expected = (1.0 - PHASES[:, None, None]) * expected[:, :, :-1] + PHASES[:, None, None] * expected[:, :, 1:]
    np.testing.assert_allclose(evaluate(points, PHASES)[0], expected[:, :, 0], atol=TOLERANCE)


@pytest.mark.parametrize("order", ORDERS)
def test_derivatives_equal_automatic_ones(order: int) -> None:
    points, s = coefficients(order), ca.SX.sym("s")
    value, first, second = bezier(ca.SX(points), s)
    function = ca.Function(
        "f", [s], [value, ca.jacobian(value, s), ca.jacobian(ca.jacobian(value, s), s), first, second]
    )
    for place, phase in enumerate(PHASES):
        results = [np.asarray(part).ravel() for part in function(phase)]
        np.testing.assert_allclose(results[3], results[1], atol=TOLERANCE * (1 + order))
        np.testing.assert_allclose(results[4], results[2], atol=TOLERANCE * (1 + order**2))
        for ours, theirs in zip(evaluate(points, PHASES), (results[0], results[3], results[4]), strict=True):
            np.testing.assert_allclose(ours[place], theirs, atol=TOLERANCE * (1 + order**2))


@pytest.mark.parametrize(("order", "raised"), [(0, 3), (1, 1), (3, 4), (4, 14), (5, 9)])
def test_elevation_keeps_the_curve(order: int, raised: int) -> None:
    points = coefficients(order)
    higher = elevate(points, raised)
    assert higher.shape == (3, raised + 1)
    for ours, theirs in zip(evaluate(higher, PHASES), evaluate(points, PHASES), strict=True):
        np.testing.assert_allclose(ours, theirs, atol=1e-11)  # second derivatives multiply rounding by order^2


@pytest.mark.parametrize("order", [3, 4, 5, 7])
def test_fit_recovers_a_curve_of_its_order(order: int) -> None:
    points = coefficients(order)
    values, rates, _ = evaluate(points, PHASES)
    np.testing.assert_allclose(fit(values, rates, PHASES, order), points, atol=1e-10)  # least squares, condition ~1e3


def test_fit_meets_both_ends_exactly_where_it_cannot_meet_the_rest() -> None:
    values, rates = np.exp(3.0 * PHASES)[:, None], 3.0 * np.exp(3.0 * PHASES)[:, None]
    ours = evaluate(fit(values, rates, PHASES, 4), PHASES)
    for sample, wanted in zip(ours[:2], (values, rates), strict=True):
        np.testing.assert_allclose(sample[[0, -1]], wanted[[0, -1]], rtol=1e-12)
    assert 1e-4 < np.abs(ours[0] - values).max() < 0.2


def test_fit_converges_with_the_order() -> None:
    values, rates = np.sin(4.0 * PHASES)[:, None], 4.0 * np.cos(4.0 * PHASES)[:, None]
    errors = [np.abs(evaluate(fit(values, rates, PHASES, order), PHASES)[0] - values).max() for order in (4, 8, 14)]
    assert errors[1] < 1e-2 * errors[0]
    assert errors[2] < 1e-8


@pytest.mark.parametrize(
    ("call", "says"),
    [
        (lambda: bernstein(-1, 0.5), "must not be negative"),
        (lambda: elevate(coefficients(4), 3), "cannot be written with order 3"),
        (lambda: fit(np.zeros((5, 1)), np.zeros((5, 1)), np.linspace(0, 1, 5), 2), "order 3 or more"),
    ],
)
def test_orders_that_do_not_exist(call: object, says: str) -> None:
    assert callable(call)
    with pytest.raises(InputError, match=says):
        call()


@settings(derandomize=True, max_examples=60, deadline=None, database=None)
@given(st.integers(0, 10), st.integers(0, 6), st.integers(0, 2**32 - 1), st.floats(0.0, 1.0), st.floats(-8.0, 8.0))
def test_elevation_keeps_values_and_derivatives(order: int, more: int, seed: int, phase: float, size: float) -> None:
    """Every elevation is a mean of neighbours, so rounding grows with their number; a derivative costs the order."""
    points = 10.0**size * np.random.default_rng(seed).normal(size=(3, order + 1))
    raised = elevate(points, order + more)
    assert raised.shape == (3, order + more + 1)
    scale = TOLERANCE * np.abs(points).max()
    pairs = zip(evaluate(points, np.array([phase])), evaluate(raised, np.array([phase])), strict=True)
    for derivative, (before, after) in enumerate(pairs):
        np.testing.assert_allclose(after, before, rtol=0.0, atol=scale * (1 + order + more) ** derivative)


@settings(derandomize=True, max_examples=60, deadline=None, database=None)
@given(st.integers(0, 6), st.integers(0, 4), st.integers(0, 4), st.integers(0, 2**32 - 1))
def test_elevation_in_two_steps_is_elevation_in_one(order: int, first: int, second: int, seed: int) -> None:
    points = np.random.default_rng(seed).normal(size=(2, order + 1))
    stepwise = elevate(elevate(points, order + first), order + first + second)
    np.testing.assert_array_equal(stepwise, elevate(points, order + first + second))
