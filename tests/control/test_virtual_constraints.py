"""References and the kernel of the output weights, against numpy."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from amble.control.phase import LATEST_PHASE, PhaseRates
from amble.control.virtual_constraints import (
    VirtualConstraints,
    commanded_acceleration,
    output_null_space,
    pack,
    repacked,
)
from amble.errors import InputError
from amble.numerics.bezier import evaluate
from amble.types import Matrix, Vector

WEIGHTS = np.eye(2, 4)


def on_time(q: ca.SX, v: ca.SX, t: ca.SX, constraints: VirtualConstraints) -> ca.SX:
    """w where the phase is time, of coordinates without a robot."""
    rates = PhaseRates(t / constraints.duration, 1.0 / constraints.duration, ca.SX(1, q.numel()), ca.SX(1, 1))
    return commanded_acceleration(q, v, rates, constraints, rates.bias)


# second derivatives of order 5 over 0.4 s: coefficients of order 1 times 5 * 4 * 4 / 0.16 = 500, a dozen roundings
ROUNDING = 1e-12


@pytest.mark.parametrize(("outputs", "coordinates"), [(1, 3), (11, 15), (12, 15), (6, 15), (3, 3)])
def test_unseen_directions_span_the_kernel(outputs: int, coordinates: int) -> None:
    weights = np.random.default_rng(outputs).normal(size=(outputs, coordinates))
    null_space = output_null_space(weights)
    assert null_space.shape == (coordinates, coordinates - outputs)
    # a few roundings
    np.testing.assert_allclose(weights @ null_space, 0.0, atol=1e-13)
    np.testing.assert_allclose(null_space.T @ null_space, np.eye(coordinates - outputs), atol=1e-14)


@pytest.mark.parametrize(("outputs", "coordinates"), [(2, 4), (3, 3)])
def test_other_weights_replace_the_kernel_alone(outputs: int, coordinates: int) -> None:
    """Also where no direction is null_space and there is no kernel to cut off."""
    generator = np.random.default_rng(7)
    references = generator.normal(size=(coordinates, 5))
    first, second = generator.normal(size=(2, outputs, coordinates))
    packed = pack(0.2, (100.0, 20.0), references, first)
    np.testing.assert_array_equal(repacked(packed, second), pack(0.2, (100.0, 20.0), references, second))


def test_dependent_outputs_are_refused() -> None:
    with pytest.raises(InputError, match="dependent"):
        output_null_space(np.array([[1.0, 2.0, 3.0], [2.0, 4.0, 6.0]]))


def test_weights_that_are_not_finite_are_refused() -> None:
    with pytest.raises(InputError, match="not finite"):
        output_null_space(np.array([[1.0, np.nan, 3.0]]))


def test_numbers_are_packed_in_the_order_of_the_symbols() -> None:
    references = np.arange(24.0).reshape(4, 6)
    constraints = VirtualConstraints.symbols(2, 4, 5)
    parts = [constraints.duration, constraints.gains, constraints.references, constraints.null_space]
    unpack = ca.Function("unpack", [constraints.packed()], parts)
    duration, gains, curves, null_space = (
        np.asarray(part) for part in unpack(pack(0.4, (3.0, 2.0), references, WEIGHTS))
    )
    assert float(duration[0, 0]) == 0.4
    assert gains.ravel().tolist() == [3.0, 2.0]
    np.testing.assert_array_equal(curves, references)
    np.testing.assert_array_equal(null_space, output_null_space(WEIGHTS))


def test_the_required_acceleration_is_the_output_dynamics_written_out() -> None:
    random = np.random.default_rng(9)
    references, q, v, kp, kd = random.normal(size=(4, 6)), random.normal(size=7), random.normal(size=7), 100.0, 20.0
    symbols = ca.SX.sym("q", 7), ca.SX.sym("v", 7), ca.SX.sym("t")
    constraints = VirtualConstraints.symbols(2, 4, 5)
    function = ca.Function("required", [*symbols, constraints.packed()], [on_time(*symbols, constraints)])
    for t in (0.0, 0.1, 0.4):
        value, rate, second = (part[0] for part in evaluate(references, np.array([t / 0.4])))
        expected = second / 0.16 - kd * (v[3:] - rate / 0.4) - kp * (q[3:] - value)
        ours = np.asarray(function(q, v, t, pack(0.4, (kp, kd), references, WEIGHTS))).ravel()
        np.testing.assert_allclose(ours, expected, atol=1e-13 * np.abs(expected).max() * kp)  # cancellation of K_p q


def curves() -> tuple[Callable[[float], list[Vector]], Matrix]:
    """Clock -> y_d, y_d', y_d'' as the required acceleration at rest contains them, with its references."""
    references, t = np.random.default_rng(8).normal(size=(4, 6)), ca.SX.sym("t")
    constraints, rest = VirtualConstraints.symbols(2, 4, 5), ca.SX.zeros(7)
    function = ca.Function("required", [t, constraints.packed()], [on_time(rest, rest, t, constraints)])

    def desired(time: float) -> list[Vector]:
        second, value, rate = (
            np.asarray(function(time, pack(0.4, gains, references, WEIGHTS))).ravel()
            for gains in ((0.0, 0.0), (1.0, 0.0), (0.0, 1.0))
        )
        return [value - second, rate - second, second]

    return desired, references


def test_the_desired_motion_is_its_bezier_curve() -> None:
    function, references = curves()
    for t in np.linspace(0.0, 0.4 * LATEST_PHASE, 9):
        value, first, second = (part[0] for part in evaluate(references, np.array([t / 0.4])))
        for ours, theirs in zip(function(t), (value, first / 0.4, second / 0.16), strict=True):
            np.testing.assert_allclose(ours, theirs, atol=ROUNDING)


def test_after_its_end_the_desired_motion_keeps_its_acceleration() -> None:
    function, _ = curves()
    end = 0.4 * LATEST_PHASE
    value, rate, second = function(end)
    for late in (0.01, 0.2):
        later = function(end + late)
        np.testing.assert_allclose(later[0], value + rate * late + 0.5 * second * late**2, atol=ROUNDING)
        np.testing.assert_allclose(later[1], rate + second * late, atol=ROUNDING)
        np.testing.assert_allclose(later[2], second, atol=ROUNDING)
