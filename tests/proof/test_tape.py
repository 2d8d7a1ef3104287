"""Expressions evaluated on balls hold what they are at every point of them."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import casadi as ca
import mpmath
import numpy as np
import pytest
from flint import arb, arb_series

from amble.errors import InputError
from amble.proof.arithmetic import working_precision
from amble.proof.tape import OPERATIONS, UndecidedError, record
from amble.proof.taylor import coefficient
from tests.proof.test_against_mpmath import CASES


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


SWITCHES = {ca.OP_FABS, ca.OP_SIGN, ca.OP_LT, ca.OP_LE, ca.OP_NOT, ca.OP_IF_ELSE_ZERO, ca.OP_FMIN, ca.OP_FMAX}
SMOOTH = {code: case for code, case in CASES.items() if code not in SWITCHES}
"""Operations with derivatives, by mpmath."""

LEADS = [0.3, 0.7, 0.0, 1.0, 2.0, -1.0]
"""First coefficients of the operands, those among them at which a power is a product."""


@pytest.mark.parametrize("code", SMOOTH)
def test_coefficients_of_a_series_are_those_of_taylor(code: int) -> None:
    """Six coefficients along polynomials with steep further ones; at points where the operation has derivatives."""
    (exact, ranges), draws, tried = SMOOTH[code], np.random.default_rng(code), 0
    with working_precision(200), mpmath.workprec(300):
        for leads in itertools.product(LEADS, repeat=len(ranges)):
            operands = [[lead, *draws.uniform(-2, 2, 5)] for lead in leads]
            try:
                at = exact(*map(mpmath.mpf, leads))
                regular = mpmath.isfinite(at) and mpmath.im(at) == 0
            except (ZeroDivisionError, ValueError):
                continue
            if not regular or (code in SINGULAR and not SINGULAR[code](*leads)):
                continue
            wanted = mpmath.taylor(
                lambda s, operands=operands: exact(*(sum(c * s**k for k, c in enumerate(each)) for each in operands)),
                0,
                5,
            )
            found = OPERATIONS[code](*(arb_series(list(map(arb, each)), prec=6) for each in operands))
            for coefficient, value in zip(found, wanted, strict=True):
                assert abs(mpmath.mpf(str(coefficient.mid().str(50, radius=False))) - value) < 1e-25 * (1 + abs(value))
            tried += 1
    assert tried >= 3


SINGULAR: dict[int, Callable[..., bool]] = {
    ca.OP_SQRT: lambda a: a > 0,
    ca.OP_ASIN: lambda a: abs(a) < 1,
    ca.OP_ACOS: lambda a: abs(a) < 1,
    ca.OP_POW: lambda a, _: a > 0,
    ca.OP_CONSTPOW: lambda a, _: a > 0,
}
"""Where operations that have a value have derivatives too."""


@pytest.mark.parametrize("divisor", [[0, 1], [0, 0, 1], [0], [arb(0, 1), 1]])
def test_a_divisor_that_may_be_zero_is_refused(divisor: list[float]) -> None:
    """t^2 / t at a clock of 0 came out as 0 + O(s^2), of which the coefficient of s was read as 0; it is 1."""
    x = ca.SX.sym("x", 2)
    along = [arb_series([0, 0, 1], prec=2), arb_series(divisor, prec=2)]
    for expression in (x[0] / x[1], 1 / x[1], x[1] ** -2):
        with pytest.raises(UndecidedError, match="divisor"):
            record(ca.Function("f", [x], [expression]))(along)


def test_a_series_is_not_read_farther_than_it_is_known() -> None:
    with pytest.raises(UndecidedError, match="not known as far"):
        coefficient(arb_series([1, 2], prec=2), 2)


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
    for expression in (ca.fmax(x, 1), ca.if_else(x < 1, x, 2 * x), ca.fabs(x - 1), ca.sign(x - 1), ca.fmin(x, 1)):
        tape = record(ca.Function("f", [x], [expression]))
        tape([arb(0.5, 0.25)])
        with pytest.raises(UndecidedError, match="cannot be decided"):
            tape([arb(1, 0.25)])


@pytest.mark.parametrize(
    "operation",
    [ca.erf, ca.floor, ca.ceil, lambda x: ca.fmod(x, 2), lambda x: ca.atan2(x, 2), lambda x: x == 0],
)
def test_what_has_no_enclosure_is_refused(operation: Callable[[ca.SX], ca.SX]) -> None:
    x = ca.SX.sym("x", 1)
    with pytest.raises(InputError, match="cannot be enclosed"):
        record(ca.Function("f", [x], [operation(x)]))


def test_the_listing_tells_expressions_and_constants_apart() -> None:
    x = ca.SX.sym("x", 2)
    listings = [
        record(ca.Function("f", [x], [expression])).listing()
        for expression in (x[0] + 0.1 * x[1], x[0] + 0.1 * x[1], x[0] + np.nextafter(0.1, 1) * x[1], x[1] + 0.1 * x[0])
    ]
    assert listings[0] == listings[1]
    assert len(set(listings)) == 3
