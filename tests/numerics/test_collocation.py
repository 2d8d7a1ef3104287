"""Collocation schemes: data that check themselves, exact quadrature, order of convergence by regression, curves."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.polynomial import Polynomial, legendre
from scipy.integrate import solve_ivp

from amble.errors import InputError, UnknownNameError
from amble.numerics.collocation import (
    HERMITE_SIMPSON,
    STAGES,
    CollocationScheme,
    collocation_scheme,
    hermite,
    node_positions,
    node_weights,
    rate_products,
    through_nodes,
)
from amble.types import frozen

SCHEMES = [collocation_scheme(name) for name in STAGES]
SIMPSON = collocation_scheme(HERMITE_SIMPSON)
TRAPEZIUM = CollocationScheme("trapezium", frozen([0.0, 1.0]), frozen([[0.0, 0.0], [0.5, 0.5]]), 2)


@pytest.mark.parametrize(
    ("nodes", "integration", "order", "says"),
    [
        ([0.0, 0.4, 1.0], SIMPSON.integration, 4, "not exact for degree"),
        ([0.1, 0.5, 1.0], SIMPSON.integration, 4, "does not span the unit interval"),
        ([0.0, 0.5, 1.0], TRAPEZIUM.integration, 4, "does not span the unit interval"),
        ([0.0, 0.5, 1.0], SIMPSON.integration, 5, "not of order 5"),
        ([0.0, 1.0], TRAPEZIUM.integration, 3, "not of order 3"),
    ],
)
def test_wrong_data_is_refused(nodes: list[float], integration: list[list[float]], order: int, says: str) -> None:
    with pytest.raises(InputError, match=says):
        CollocationScheme("wrong", frozen(nodes), frozen(integration), order)


def test_one_wrong_entry_is_refused() -> None:
    entries = np.array(SIMPSON.integration)
    entries[1, 1] += 1e-9
    with pytest.raises(InputError, match="not exact for degree 0"):
        CollocationScheme("wrong", SIMPSON.nodes, frozen(entries), 4)


@pytest.mark.parametrize("scheme", [*SCHEMES, TRAPEZIUM])
@pytest.mark.parametrize("intervals", [1, 2, 7])
def test_weights_integrate_what_their_order_promises(scheme: CollocationScheme, intervals: int) -> None:
    positions, weights = node_positions(scheme, intervals), node_weights(scheme, intervals)
    assert positions.size == weights.size == intervals * (scheme.nodes.size - 1) + 1
    assert positions[0] == 0.0
    assert positions[-1] == 1.0
    assert np.all(np.diff(positions) > 0.0)
    for degree in range(scheme.order):
        assert weights @ positions**degree == pytest.approx(1.0 / (degree + 1), abs=1e-14)  # a sum of n roundings
    if intervals == 1:
        assert abs(weights @ positions**scheme.order - 1.0 / (scheme.order + 1)) > 1e-8


COUNTS = {2: (8, 16, 32, 64), 3: (8, 16, 32, 64), 5: (4, 6, 8, 12), 7: (2, 3, 4, 5)}
"""Stages -> numbers of steps over a motion, down to where rounding begins to show."""


@pytest.mark.parametrize("scheme", [*SCHEMES, TRAPEZIUM])
def test_order_of_convergence(scheme: CollocationScheme) -> None:
    """A nonlinear pendulum, by regression of log error on log step, against a step of DOP853 at 1e-13."""
    counts = np.array(COUNTS[scheme.stages])
    errors = [np.abs(_travelled(scheme, int(count)) - PENDULUM).max() for count in counts]
    slope = np.polyfit(np.log(1.0 / counts), np.log(errors), 1)[0]
    assert slope == pytest.approx(scheme.order, abs=0.06 * scheme.order)  # the next term of the error bends the line


def _rate(x: np.ndarray) -> np.ndarray:
    return np.stack([x[..., 1], -np.sin(x[..., 0])], axis=-1)


START, TIME = np.array([1.2, 0.3]), 3.0
PENDULUM = solve_ivp(lambda _, x: _rate(x), (0.0, TIME), START, "DOP853", rtol=1e-13, atol=1e-14).y[:, -1]


def _travelled(scheme: CollocationScheme, count: int) -> np.ndarray:
    """Steps whose stages are solved by Newton."""
    step, state, size = TIME / count, START, 2 * scheme.stages
    for _ in range(count):
        x = np.tile(state, (scheme.stages, 1))
        for _ in range(8):
            slopes = np.zeros((scheme.stages, 2, 2))
            slopes[:, 0, 1], slopes[:, 1, 0] = 1.0, -np.cos(x[:, 0])
            jacobian = np.eye(size) - step * np.einsum("ij,jab->iajb", scheme.integration, slopes).reshape(size, size)
            defect = x - state - step * scheme.integration @ _rate(x)
            x = x - np.linalg.solve(jacobian, defect.ravel()).reshape(x.shape)
        state = x[-1]
    return state


@pytest.mark.parametrize("scheme", SCHEMES)
def test_nodes_and_weights_are_those_of_lobatto(scheme: CollocationScheme) -> None:
    """Ends and zeros of P'_(s-1), weights 1 / (s (s-1) P_(s-1)^2) (Abramowitz and Stegun 25.4.32, on [0, 1])."""
    s = scheme.stages
    last = np.eye(s)[-1]
    inner = legendre.legroots(legendre.legder(last))
    np.testing.assert_allclose(2.0 * scheme.nodes - 1.0, [-1.0, *np.sort(inner), 1.0], atol=1e-14)
    wanted = 1.0 / (s * (s - 1) * legendre.legval(2.0 * scheme.nodes - 1.0, last) ** 2)
    np.testing.assert_allclose(scheme.weights, wanted, rtol=1e-13)


def test_three_nodes_are_hermite_simpson_to_the_last_bit() -> None:
    wanted = [[0.0, 0.0, 0.0], [5 / 24, 8 / 24, -1 / 24], [1 / 6, 4 / 6, 1 / 6]]
    np.testing.assert_array_equal(SIMPSON.integration, wanted)
    np.testing.assert_array_equal(SIMPSON.nodes, [0.0, 0.5, 1.0])


@pytest.mark.parametrize("scheme", SCHEMES)
def test_rate_products_integrate_the_squared_slope(scheme: CollocationScheme) -> None:
    curve = Polynomial(np.random.default_rng(1).normal(size=scheme.stages))
    values, squared = curve(scheme.nodes), (curve.deriv() ** 2).integ()
    assert values @ rate_products(scheme.name) @ values == pytest.approx(squared(1.0) - squared(0.0), rel=1e-12)


@pytest.mark.parametrize("scheme", SCHEMES)
def test_curves_through_nodes_are_exact_up_to_their_degree(scheme: CollocationScheme) -> None:
    """Degree s - 1 through values, 2 s - 1 through values and rates, in two intervals; one more is missed in one."""
    random, at = np.random.default_rng(2), np.linspace(0.0, 1.0, 37)
    for most, rates in ((scheme.stages - 1, False), (2 * scheme.stages - 1, True)):
        for degree, intervals in ((most, 2), (most + 1, 1)):
            nodes = node_positions(scheme, intervals)
            curves = [Polynomial([*random.normal(size=degree), 1.0]) for _ in range(3)]
            values, slopes = (np.stack([curve.deriv(k)(nodes) for curve in curves], axis=1) for k in (0, 1))
            found = hermite(scheme.name, values, slopes, at) if rates else through_nodes(scheme.name, values, at)
            missed = np.abs(found - np.stack([curve(at) for curve in curves], axis=1)).max()
            assert (missed < 1e-11) == (degree == most)  # roundings; the first coefficient missed counts 1e-8


@pytest.mark.parametrize("scheme", SCHEMES)
def test_what_the_scheme_integrates_is_met_between_the_nodes(scheme: CollocationScheme) -> None:
    """Values that follow from rates by the Butcher matrix lie on the integral of the polynomial through the rates."""
    random, h = np.random.default_rng(3), 0.5
    rates = Polynomial(random.normal(size=scheme.stages))
    nodes = node_positions(scheme, 2)
    first = 0.7 + h * scheme.integration @ rates(nodes[: scheme.stages])
    second = first[-1] + h * scheme.integration @ rates(nodes[scheme.stages - 1 :])
    values, at = np.concatenate([first, second[1:]]), np.linspace(0.0, 1.0, 23)
    found = hermite(scheme.name, values[:, None], rates(nodes)[:, None], at)[:, 0]
    np.testing.assert_allclose(found, 0.7 + rates.integ()(at), atol=1e-12)


def test_an_unknown_scheme_is_named() -> None:
    with pytest.raises(UnknownNameError, match="collocation scheme 'radau'; known: hermite-simpson, lobatto-5"):
        collocation_scheme("radau")
