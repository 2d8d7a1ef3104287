"""Balls and their decimal strings, held against rational arithmetic."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest
from flint import arb

from amble.proof.arithmetic import decimals, fraction, from_decimals, working_precision


def rational(text: str) -> Fraction:
    return Fraction(text)


@pytest.mark.parametrize("bits", [53, 128])
def test_every_operation_holds_the_rational_result(bits: int) -> None:
    """+ - * / of random numbers of sizes 1e-30 to 1e30: the exact quotient of integers lies in the ball."""
    draws = np.random.default_rng(0)
    with working_precision(bits):
        for _ in range(2000):
            a, b = (float(draws.normal() * 10.0 ** draws.integers(-30, 30)) for _ in range(2))
            exact = [
                Fraction(a) + Fraction(b),
                Fraction(a) - Fraction(b),
                Fraction(a) * Fraction(b),
                Fraction(a) / Fraction(b),
            ]
            for ball, value in zip((arb(a) + b, arb(a) - b, arb(a) * b, arb(a) / b), exact, strict=True):
                assert fraction(ball.lower()) <= value <= fraction(ball.upper())


def test_decimal_strings_are_rounded_outward() -> None:
    draws = np.random.default_rng(1)
    with working_precision(100):
        for _ in range(500):
            middle = float(draws.normal() * 10.0 ** draws.integers(-30, 30))
            ball = arb(middle, abs(middle) * 10.0 ** float(draws.uniform(-25, -1)))
            low, high = map(rational, decimals(ball, 12))
            assert low <= fraction(ball.lower())
            assert fraction(ball.upper()) <= high
            again = from_decimals(*decimals(ball, 12))
            assert again.contains(ball)


def test_decimals_of_zero_and_of_whole_numbers() -> None:
    assert decimals(arb(0)) == ("0", "0")
    low, high = decimals(arb(12345))
    assert rational(low) == rational(high) == 12345


def test_the_precision_is_given_back() -> None:
    from flint import ctx

    before = ctx.prec
    with working_precision(77):
        assert ctx.prec == 77
    assert ctx.prec == before
