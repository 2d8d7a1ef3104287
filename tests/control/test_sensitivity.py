"""The closed loop's derivatives against automatic and finite differences."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np
import pytest

from amble.control.sensitivity import sensitivity
from amble.control.virtual_constraints import pack
from amble.hybrid import Contacts, Stance
from amble.types import Matrix
from tests.control.loops import Sample, expressions, samples, solved_stances, weights
from tests.robots import robot

STANCES = solved_stances()


@lru_cache(maxsize=2)
def slopes(feet: tuple[str, ...], outputs: int = 11) -> ca.Function:
    """(q, v, t, p) -> acceleration slope, error slope, response, automatic Jacobian of the acceleration."""
    at, linearised = expressions(feet, "pinv", outputs)
    ours = sensitivity(Contacts(robot("astro"), feet), linearised, at.q, at.v, at.constraints)
    automatic = ca.jacobian(linearised.acceleration, ca.vertcat(at.q, at.v))
    parts = [ours.acceleration, ours.error, ours.response, automatic, linearised.acceleration]
    return ca.Function("slopes", at.arguments, [ca.densify(part) for part in parts])


@pytest.fixture(params=STANCES, ids=[stance.name for stance in STANCES])
def stance(request: pytest.FixtureRequest) -> Stance:
    return request.param


def evaluated(stance: Stance, sample: Sample, chosen: Matrix) -> tuple[Matrix, ...]:
    return tuple(np.asarray(part) for part in slopes(stance.feet)(*sample.arguments(chosen)))


def test_equals_automatic_differentiation(stance: Stance) -> None:
    for sample, mixed in samples(5, seed=11, mixed=True):
        for chosen in (weights(stance), mixed):
            assert chosen is not None
            ours, _, _, automatic, _ = evaluated(stance, sample, chosen)
            # two orders of the same solves, with conditions of up to 1e4
            np.testing.assert_allclose(ours, automatic, atol=1e-9 * np.abs(automatic).max())


@pytest.mark.parametrize(
    ("feet", "outputs"), [((), 12), (("rl",), 12), (("fl", "fr", "rl"), 9), (("fl", "fr", "rl", "rr"), 6)]
)
def test_any_number_of_feet_equals_automatic_differentiation(feet: tuple[str, ...], outputs: int) -> None:
    random = np.random.default_rng(outputs)
    for sample, _ in samples(3, seed=17):
        found = slopes(feet, outputs)(*sample.arguments(random.normal(size=(outputs, sample.q.size - 3))))
        ours, automatic = np.asarray(found[0]), np.asarray(found[3])
        np.testing.assert_allclose(ours, automatic, atol=1e-9 * np.abs(automatic).max())  # as above


def test_equals_central_differences(stance: Stance) -> None:
    (sample, _), chosen, step = samples(1, seed=12)[0], weights(stance), 1e-5
    ours = evaluated(stance, sample, chosen)[0]
    size = sample.q.size
    for column in range(2 * size):
        moved = []
        for sign in (1.0, -1.0):
            q, v = sample.q.copy(), sample.v.copy()
            (q if column < size else v)[column % size] += sign * step
            there = Sample(q, v, sample.t, sample.duration, sample.gains, sample.references)
            moved.append(evaluated(stance, there, chosen)[4][:, 0])
        difference = (moved[0] - moved[1]) / (2.0 * step)
        # truncation step^2 times third derivatives, rounding 1e-16 / step times accelerations of 1e3
        np.testing.assert_allclose(ours[:, column], difference, atol=1e-6 * np.abs(ours).max())


def test_weighted_errors_have_no_slope(stance: Stance) -> None:
    """H E = 0 and H S R = H: the outputs obey their dynamics whatever the state."""
    for sample, mixed in samples(5, seed=13, mixed=True):
        for chosen in (weights(stance), mixed):
            assert chosen is not None
            _, error, response, _, _ = evaluated(stance, sample, chosen)
            np.testing.assert_allclose(chosen @ error, 0.0, atol=1e-8 * np.abs(error).max())
            np.testing.assert_allclose(chosen @ response[3:], chosen, atol=1e-10 * np.abs(response).max())


def test_on_an_orbit_a_change_of_weights_acts_through_the_error(stance: Stance) -> None:
    """On the orbit d(acceleration slope) = -R H^+ dH E (docs/theory/virtual-constraints.md, eq. 18)."""
    chosen = weights(stance)
    (sample, _), step = samples(1, seed=14)[0], 1e-6
    change = np.random.default_rng(15).normal(size=chosen.shape)
    sample = _on_orbit(stance, sample, chosen)
    _, error, response, _, acceleration = evaluated(stance, sample, chosen)
    moved = [evaluated(stance, sample, chosen + sign * step * change) for sign in (1.0, -1.0)]
    np.testing.assert_allclose(moved[0][4], acceleration, atol=1e-6 * np.abs(acceleration).max())  # the orbit stays
    difference = (moved[0][0] - moved[1][0]) / (2.0 * step)
    expected = -response @ np.linalg.pinv(chosen) @ change @ error
    np.testing.assert_allclose(difference, expected, atol=1e-5 * np.abs(expected).max())


def _on_orbit(stance: Stance, sample: Sample, chosen: Matrix) -> Sample:
    """The sample with references that start at its state and, for every coordinate, at its own acceleration."""
    second = np.random.default_rng(16).normal(0.0, 5.0, sample.q.size - 3)
    for _ in range(2):  # once for the controlled coordinates, once more for those that follow
        references = _quadratic(sample, second)
        there = Sample(sample.q, sample.v, 0.0, sample.duration, sample.gains, references)
        p = pack(there.duration, there.gains, references, chosen)
        second = np.asarray(slopes(stance.feet)(there.q, there.v, 0.0, p)[4]).ravel()[3:]
    return there


def _quadratic(sample: Sample, second: Matrix) -> Matrix:
    """Bezier coefficients of order 4 of the parabola with the sample's value and rate."""
    value, rate = sample.q[3:, None], sample.v[3:, None] * sample.duration
    power = np.arange(5) / 4.0
    return value + rate * power + 0.5 * second[:, None] * sample.duration**2 * power * (4.0 * power - 1.0) / 3.0
