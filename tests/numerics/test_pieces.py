"""Polynomial pieces: accuracy, corners and jumps, and the same curve as numbers and as expressions."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.errors import WorkError
from amble.numerics.pieces import ORDER, evaluated, fitted, padded
from amble.types import Matrix, Vector


def curve(times: Vector) -> Matrix:
    """Smooth, with a corner, with a jump."""
    corner = 30.0 * np.abs(times - 0.0312345) + np.exp(-10.0 * times)
    return np.stack([np.sin(20.0 * times), corner, np.where(times < 0.0654321, 1.0, np.cos(times))], axis=1)


def test_pieces_meet_the_function_away_from_its_jump() -> None:
    found = fitted(curve, 0.0, 0.11, 1e-10)
    times = np.linspace(0.0, 0.11, 2001)
    away = np.abs(times - 0.0654321) > 1e-9
    values, rates = found(times)
    assert np.abs(values - curve(times))[away].max() < 1e-9
    # Markov: the slope of an error of 1e-10 in a piece of half length 0.01 is at most 121 / 0.01 times as large
    assert np.abs(rates[:, 0] - 20.0 * np.cos(20.0 * times)).max() < 1e-5


@pytest.mark.parametrize("seed", range(5))
def test_a_corner_is_cut_out(seed: int) -> None:
    """Whatever its place: the halvings that look for it leave one cut, or a few close together."""
    place = float(np.random.default_rng(seed).uniform(0.1, 0.9))
    found = fitted(lambda times: np.abs(times - place)[:, None], 0.0, 1.0, 1e-9)
    assert found.count <= 4
    np.testing.assert_allclose(found.breaks[1:-1], place, atol=1e-6)


def test_further_cuts_change_nothing() -> None:
    found = fitted(curve, 0.0, 0.11, 1e-10)
    more = found.cut(np.array([-1.0, 0.01, 0.05, 0.2]))
    assert more.count == found.count + 2
    times = np.linspace(-0.001, 0.111, 301)
    np.testing.assert_allclose(more(times)[0], found(times)[0], atol=1e-11)


def test_expressions_are_the_numbers() -> None:
    found = fitted(curve, 0.0, 0.11, 1e-10)
    count = found.count + 3
    places, coefficients = padded(found, count)
    t, a, b = ca.SX.sym("t"), ca.SX.sym("a", 2, count), ca.SX.sym("b", count * 3 * (ORDER + 1))
    function = ca.Function("curves", [t, a, b], list(evaluated(a, b, 3, t)))
    for time in (-0.01, 0.0, 0.0312, 0.0654321, 0.1, 0.12):
        for ours, theirs in zip(function(time, places, coefficients.ravel()), found(np.array([time])), strict=True):
            np.testing.assert_allclose(np.asarray(ours).ravel(), theirs[0], rtol=1e-10, atol=1e-10)


def test_what_no_pieces_meet_is_refused() -> None:
    with pytest.raises(WorkError, match="polynomial pieces"):
        fitted(lambda times: np.sin(1.0 / (times + 1e-3))[:, None], 0.0, 1.0, 1e-12)
    with pytest.raises(WorkError, match="not finite"):
        fitted(lambda times: np.full((times.size, 1), np.nan), 0.0, 1.0, 1e-9)
