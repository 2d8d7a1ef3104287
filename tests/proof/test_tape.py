"""Expressions evaluated on balls hold what they are at every point of them."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from flint import arb, arb_series

from amble.errors import InputError
from amble.proof.arithmetic import working_precision
from amble.proof.tape import UndecidedError, record


def expressions(x: ca.SX) -> list[ca.SX]:
    a, b = x[0], x[1]
    return [
        ca.sin(a) * ca.cos(b) + ca.tan(a) - a / b,
        ca.exp(-a) + ca.log(b) + ca.sqrt(b) + ca.tanh(a),
        a**3 + b**-2 + b**a + 2 * a + ca.atan(a) + ca.asin(a / 4) + ca.acos(a / 4),
        ca.fmax(a, 10) + ca.fmin(b, 10) + ca.fabs(b) + ca.if_else(a < b + 5, a, b) + ca.if_else(a > b + 5, a, -b),
    ]


def test_points_of_a_box_lie_in_the_image_of_the_box() -> None:
    """Floating point errs by some units in the last place; the images are 1e-3 wide."""
    x = ca.SX.sym("x", 2)
    function = ca.Function("f", [x], [ca.vertcat(*expressions(x))])
    tape, draws = record(function), np.random.default_rng(0)
    for _ in range(50):
        centre = np.array([draws.uniform(-1, 1), draws.uniform(0.5, 3)])
        (image,) = tape([arb(float(value), 1e-3) for value in centre])
        for _ in range(20):
            point = np.asarray(function(centre + draws.uniform(-1e-3, 1e-3, 2))).reshape(-1)
            assert all(ball.contains(arb(float(value))) for ball, value in zip(image, point, strict=True))


def test_exact_points_are_sharp() -> None:
    """At 200 bits the ball is the value to floating-point accuracy: 1e-13 allows its last places."""
    x = ca.SX.sym("x", 2)
    function = ca.Function("f", [x], [ca.vertcat(*expressions(x))])
    with working_precision(200):
        (image,) = record(function)([arb(0.3), arb(2.0)])
        assert [float(value) for value in image] == pytest.approx(
            np.asarray(function([0.3, 2.0])).reshape(-1), rel=1e-13
        )
        assert max(float(value.rad()) for value in image) < 1e-50


def test_a_series_holds_the_derivatives() -> None:
    """Along x(s) = x + s d the coefficient of s is the directional derivative, by casadi's differentiation."""
    x, d = ca.SX.sym("x", 2), ca.SX.sym("d", 2)
    f = ca.vertcat(*expressions(x))
    slope = ca.Function("slope", [x, d], [ca.jtimes(f, x, d)])
    tape = record(ca.Function("f", [x], [f]))
    (along,) = tape([arb_series([arb(0.3), arb(0.7)], prec=2), arb_series([arb(2), arb(-1.1)], prec=2)])
    found = [float(value[1]) for value in along]
    assert found == pytest.approx(np.asarray(slope([0.3, 2.0], [0.7, -1.1])).reshape(-1), rel=1e-12)


def test_a_switch_that_depends_on_the_point_is_not_decided() -> None:
    x = ca.SX.sym("x", 1)
    for expression in (ca.fmax(x, 1), ca.if_else(x < 1, x, 2 * x), ca.fabs(x - 1), ca.fmin(x, 1)):
        tape = record(ca.Function("f", [x], [expression]))
        tape([arb(0.5, 0.25)])
        with pytest.raises(UndecidedError, match="cannot be decided"):
            tape([arb(1, 0.25)])


def test_what_is_no_expression_is_refused() -> None:
    x = ca.SX.sym("x", 1)
    with pytest.raises(InputError, match="cannot be enclosed"):
        record(ca.Function("f", [x], [ca.erf(x)]))


def test_the_listing_tells_expressions_and_constants_apart() -> None:
    x = ca.SX.sym("x", 2)
    listings = [
        record(ca.Function("f", [x], [expression])).listing()
        for expression in (x[0] + 0.1 * x[1], x[0] + 0.1 * x[1], x[0] + np.nextafter(0.1, 1) * x[1], x[1] + 0.1 * x[0])
    ]
    assert listings[0] == listings[1]
    assert len(set(listings)) == 3
