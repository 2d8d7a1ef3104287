"""Every operation on balls against mpmath, which shares no code with Arb: points of the balls land in the result."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import mpmath
import numpy as np
import pytest
from flint import arb

from amble.proof.arithmetic import working_precision
from amble.proof.tape import OPERATIONS

DIGITS = 60
Case = tuple[Callable[..., Any], tuple[tuple[float, float], ...]]
"""The function in mpmath, and the ranges of its operands."""

ANY, POSITIVE, UNIT, SMALL = (-30.0, 30.0), (1e-3, 30.0), (-0.98, 0.98), (-1.5, 1.5)
CASES: dict[int, Case] = {
    ca.OP_ASSIGN: (lambda a: a, (ANY,)),
    ca.OP_ADD: (lambda a, b: a + b, (ANY, ANY)),
    ca.OP_SUB: (lambda a, b: a - b, (ANY, ANY)),
    ca.OP_MUL: (lambda a, b: a * b, (ANY, ANY)),
    ca.OP_DIV: (lambda a, b: a / b, (ANY, POSITIVE)),
    ca.OP_NEG: (lambda a: -a, (ANY,)),
    ca.OP_INV: (lambda a: 1 / a, (POSITIVE,)),
    ca.OP_SQ: (lambda a: a * a, (ANY,)),
    ca.OP_TWICE: (lambda a: a + a, (ANY,)),
    ca.OP_SQRT: (mpmath.sqrt, (POSITIVE,)),
    ca.OP_SIN: (mpmath.sin, (ANY,)),
    ca.OP_COS: (mpmath.cos, (ANY,)),
    ca.OP_TAN: (mpmath.tan, (SMALL,)),
    ca.OP_ASIN: (mpmath.asin, (UNIT,)),
    ca.OP_ACOS: (mpmath.acos, (UNIT,)),
    ca.OP_ATAN: (mpmath.atan, (ANY,)),
    ca.OP_EXP: (mpmath.exp, (ANY,)),
    ca.OP_LOG: (mpmath.log, (POSITIVE,)),
    ca.OP_POW: (mpmath.power, (POSITIVE, (-4.0, 4.0))),
    ca.OP_CONSTPOW: (mpmath.power, (POSITIVE, (-4.0, 4.0))),
    ca.OP_TANH: (mpmath.tanh, (ANY,)),
    ca.OP_FABS: (abs, (POSITIVE,)),
    ca.OP_SIGN: (mpmath.sign, (POSITIVE,)),
    ca.OP_LT: (lambda a, b: mpmath.mpf(a < b), ((-30.0, -1.0), (1.0, 30.0))),
    ca.OP_LE: (lambda a, b: mpmath.mpf(a <= b), ((1.0, 30.0), (-30.0, -1.0))),
    ca.OP_NOT: (lambda a: mpmath.mpf(a == 0), (POSITIVE,)),
    ca.OP_IF_ELSE_ZERO: (lambda a, b: b if a != 0 else mpmath.mpf(0), (POSITIVE, ANY)),
    ca.OP_FMIN: (min, ((-30.0, -1.0), (1.0, 30.0))),
    ca.OP_FMAX: (max, ((-30.0, -1.0), (1.0, 30.0))),
}


def test_every_operation_has_its_case() -> None:
    assert CASES.keys() == OPERATIONS.keys()


@pytest.mark.parametrize(
    "count", [pytest.param(60, id="some"), pytest.param(36_000, id="a-million", marks=pytest.mark.slow)]
)
def test_points_of_balls_land_in_the_result(count: int) -> None:
    """Operands are balls of radii 1e-3 to 1e-25 of a unit, or exact; mpmath has 60 digits, Arb 64, 100 or 128 bits.

    A point of a ball is its middle and a multiple of 1/2 of its radius, exact in 60 digits. The result is as sharp as
    the slope over the operands allows; how sharp is asked of exact operands alone: their result has all its bits but 8.
    """
    draws, tried = np.random.default_rng(0), 0
    with mpmath.workdps(DIGITS):
        for code, (function, ranges) in CASES.items():
            for bits in (64, 100, 128):
                with working_precision(bits):
                    for number in range(count // 3):
                        operands, point = zip(
                            *(ball(draws, ends, exact=number % 8 == 0) for ends in ranges), strict=True
                        )
                        result, value = OPERATIONS[code](*operands), mpmath.mpf(function(*point))
                        assert result.overlaps(as_ball(value)), (code, operands)
                        if number % 8 == 0:
                            assert result.rad() <= abs(result.mid()) * arb(2) ** (8 - bits) + arb(2) ** (8 - bits), code
                        tried += 1
    assert tried == len(CASES) * 3 * (count // 3)


def ball(draws: np.random.Generator, ends: tuple[float, float], exact: bool) -> tuple[arb, Any]:
    """Draw a ball that lies in a range, and a point of it."""
    radius = 0.0 if exact else float(2.0 ** -draws.integers(10, 84))
    middle = float(draws.uniform(ends[0] + radius, ends[1] - radius)) if ends[1] - ends[0] > 2 * radius else ends[0]
    share = float(draws.integers(-2, 3)) / 2.0
    return arb(middle, radius), mpmath.mpf(middle) + mpmath.mpf(share) * mpmath.mpf(radius)


def as_ball(value: Any) -> arb:
    """Return a number of mpmath with its rounding."""
    sign, mantissa, exponent, _ = value._mpf_
    with working_precision(240):
        middle = arb((int(-mantissa if sign else mantissa), int(exponent)))
        return middle + arb(0, abs(middle).upper() * arb(10) ** (4 - DIGITS))
