"""Validated steps against the exact exponential and against motions in closed form."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from flint import arb

from amble.hybrid import Domain
from amble.proof.arithmetic import column, exact_matrix, working_precision
from amble.proof.explicit_field import ExplicitField
from amble.proof.step import take_step
from amble.proof.taylor import variation
from amble.types import Matrix


def linear(matrix: Matrix) -> ExplicitField:
    x = ca.SX.sym("x", len(matrix))
    return ExplicitField.of(Domain.from_expressions("linear", x, ca.mtimes(ca.DM(matrix), x)))


@pytest.mark.parametrize(("size", "seed"), [(2, 0), (3, 1), (5, 2)])
def test_linear_systems_against_the_matrix_exponential(size: int, seed: int) -> None:
    """x(h) = exp(h A) x and dx(h)/dx(0) = exp(h A), where Arb's exponential is another algorithm: the balls meet, and
    the step's are as sharp as its remainder (0.2 |A|)^20 / 20! allows."""
    draws = np.random.default_rng(seed)
    matrix = draws.normal(size=(size, size))
    with working_precision(160):
        centre = [arb(float(value)) for value in draws.normal(size=size)]
        box = [value + arb(0, 1e-12) for value in centre]
        done = take_step(linear(matrix), arb(0), centre, box, arb(0.1), 20)
        flow = (exact_matrix(matrix) * done.length).exp()
        image = (flow * column(centre)).entries()
        assert all(ball.overlaps(value) for ball, value in zip(done.image, image, strict=True))
        assert done.slope.overlaps(flow)
        assert max(float(ball.rad()) for ball in done.image) < 1e-25
        for value, start in zip(done.parts[0].box, centre, strict=True):
            assert value.contains(start)


def test_motions_of_random_starts_stay_in_tube_and_image() -> None:
    """x' = 1 + x^2 from x0: x = tan(t + atan x0)."""
    x = ca.SX.sym("x", 1)
    field = ExplicitField.of(Domain.from_expressions("up", x, 1 + x**2))
    draws = np.random.default_rng(3)
    with working_precision(128):
        centre, radius = arb(0.25), 1e-3
        done = take_step(field, arb(0), [centre], [centre + arb(0, radius)], arb(0.25), 16)
        image = done.image[0] + done.slope[0, 0] * arb(0, radius)
        for _ in range(200):
            start = arb(0.25 + float(draws.uniform(-radius, radius)))
            moved = (done.length + start.atan()).tan()
            assert image.contains(moved)
            between = (done.length * float(draws.uniform()) + start.atan()).tan()
            assert done.parts[0].box[0].contains(between)


def test_the_coefficients_of_the_exponential() -> None:
    x = ca.SX.sym("x", 1)
    field = ExplicitField.of(Domain.from_expressions("grow", x, x))
    motion = field.motion(arb(0), [arb(1)], 12)
    for power, (value,) in enumerate(motion):
        assert value.overlaps(1 / arb.fac_ui(power))
    slopes = field.slopes(arb(0), motion[:12])
    for power, value in enumerate(variation(slopes, exact_matrix(np.eye(1)), 12)):
        assert value[0, 0].overlaps(1 / arb.fac_ui(power))


def test_the_clock_is_part_of_the_field() -> None:
    """x' = t from clock 1: x(h) = x0 + h + h^2 / 2."""
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 1)
    field = ExplicitField.of(Domain.from_expressions("ramp", x, t, clock=t))
    done = take_step(field, arb(1), [arb(2)], [arb(2)], arb(0.5), 6)
    assert done.image[0].contains(arb(2.625))
    assert float(done.image[0].rad()) < 1e-12
