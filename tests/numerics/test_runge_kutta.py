"""Collocation schemes: data that check themselves, exact quadrature, order of convergence by regression."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from amble.errors import InputError, WorkError
from amble.numerics.runge_kutta import (
    HERMITE_SIMPSON,
    STAGES,
    CollocationScheme,
    Tableau,
    dop853,
    node_positions,
    node_weights,
)
from amble.types import frozen

TRAPEZIUM = CollocationScheme("trapezium", frozen([0.0, 1.0]), frozen([[0.0, 0.0], [0.5, 0.5]]), 2)


@pytest.mark.parametrize(
    ("nodes", "integration", "order", "says"),
    [
        ([0.0, 0.4, 1.0], HERMITE_SIMPSON.integration, 4, "not exact for degree"),
        ([0.1, 0.5, 1.0], HERMITE_SIMPSON.integration, 4, "does not span the unit interval"),
        ([0.0, 0.5, 1.0], TRAPEZIUM.integration, 4, "does not span the unit interval"),
        ([0.0, 0.5, 1.0], HERMITE_SIMPSON.integration, 5, "not of order 5"),
        ([0.0, 1.0], TRAPEZIUM.integration, 3, "not of order 3"),
    ],
)
def test_wrong_data_is_refused(nodes: list[float], integration: list[list[float]], order: int, says: str) -> None:
    with pytest.raises(InputError, match=says):
        CollocationScheme("wrong", frozen(nodes), frozen(integration), order)


def test_one_wrong_entry_is_refused() -> None:
    entries = np.array(HERMITE_SIMPSON.integration)
    entries[1, 1] += 1e-9
    with pytest.raises(InputError, match="not exact for degree 0"):
        CollocationScheme("wrong", HERMITE_SIMPSON.nodes, frozen(entries), 4)


@pytest.mark.parametrize("scheme", [HERMITE_SIMPSON, TRAPEZIUM])
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
        assert abs(weights @ positions**scheme.order - 1.0 / (scheme.order + 1)) > 1e-3


@pytest.mark.parametrize("scheme", [HERMITE_SIMPSON, TRAPEZIUM])
def test_order_of_convergence(scheme: CollocationScheme) -> None:
    """x'' = -x over one turn, by regression of log error on log step."""
    field = np.array([[0.0, 1.0], [-1.0, 0.0]])
    counts = np.array([8, 16, 32, 64])
    slope = np.polyfit(np.log(1.0 / counts), np.log([_error(scheme, field, n) for n in counts]), 1)[0]
    assert slope == pytest.approx(scheme.order, abs=0.1)  # the next term of the error bends the line by a few percent


def _error(scheme: CollocationScheme, field: np.ndarray, count: int) -> float:
    step, stages = 2.0 * np.pi / count, scheme.nodes.size
    state = start = np.array([1.0, 0.0])
    implicit = np.eye(2 * stages) - step * np.kron(scheme.integration, field)
    for _ in range(count):
        state = np.linalg.solve(implicit, np.tile(state, stages))[-2:]
    return float(np.abs(state - start).max())


def rate(x: np.ndarray) -> np.ndarray:
    """A nonlinear pendulum: the order must hold where the field is not linear."""
    return np.array([x[1], -np.sin(x[0])])


def stages(method: Tableau, x: np.ndarray, length: float) -> np.ndarray:
    k = np.zeros((16, x.size))
    for s in range(16):
        k[s] = rate(x + length * method.a[s] @ k)
    return k


def travel(steps: int) -> np.ndarray:
    method, x, length = dop853(), np.array([1.2, 0.3]), 3.0 / steps
    for _ in range(steps):
        x = x + length * method.a[STAGES] @ stages(method, x, length)
    return x


def test_the_step_is_of_order_8() -> None:
    counts = np.array([6, 8, 10, 13, 16])
    reference = travel(200)
    errors = [np.abs(travel(int(n)) - reference).max() for n in counts]
    order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
    assert order == pytest.approx(8.0, abs=0.7)  # a regression over a finite range of steps


@pytest.mark.parametrize(("estimate", "order"), [("error5", 5), ("error3", 3)])
def test_the_error_estimates_have_their_orders(estimate: str, order: int) -> None:
    method, x = dop853(), np.array([1.2, 0.3])
    lengths = np.array([0.4, 0.3, 0.2, 0.1])
    sizes = [length * np.abs(getattr(method, estimate) @ stages(method, x, length)[:13]).max() for length in lengths]
    measured = np.polyfit(np.log(lengths), np.log(sizes), 1)[0]
    assert measured == pytest.approx(order + 1, abs=0.7)  # a local error is one order higher


@pytest.mark.parametrize("field", ["a", "c", "error3", "error5"])
def test_a_wrong_digit_is_noticed(field: str) -> None:
    method = dop853()
    wrong = np.array(getattr(method, field))
    wrong[(5, 3) if wrong.ndim == 2 else 5] += 1e-6
    with pytest.raises(WorkError, match="do not fit together"):
        dataclasses.replace(method, **{field: wrong})
