"""DOP853: its order and those of its error estimates by regression; a wrong digit is noticed."""

from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from amble.errors import WorkError
from amble.numerics.runge_kutta import STAGES, Tableau, dop853


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
