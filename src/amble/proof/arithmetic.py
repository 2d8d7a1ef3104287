"""Balls of real numbers: what the proof computes with, every operation rounded outward by Arb (python-flint).

A ball is a midpoint with a radius and stands for every real number in it. The result of an operation holds the result
for every choice of numbers in the operands (Johansson 2017, Arb: efficient arbitrary-precision midpoint-radius interval
arithmetic). A comparison of two balls is true only where it holds for all of their numbers, so a test that is not true
proves nothing, not the contrary.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from fractions import Fraction
from typing import TypeVar

import numpy as np
from flint import arb, arb_mat, ctx

from amble.types import Matrix

DIGITS = 40
"""Decimal digits of a written bound."""
SMALLEST = -999
"""Exponent of ten of the last digit that is written of any bound."""
ROOM = arb(2) ** -4
"""Share of its radius by which a ball is widened before anything is claimed of it. Arb bounds the errors of a product
of series block by block, and the blocks depend on the precision: in another one balls come out wider by up to 1e-4."""


@contextmanager
def working_precision(bits: int) -> Iterator[None]:
    """Compute with midpoints of so many bits inside the block."""
    before = ctx.prec
    ctx.prec = bits
    try:
        yield
    finally:
        ctx.prec = before


def between(low: arb, high: arb) -> arb:
    """Return the smallest ball that holds two balls and all between them."""
    return low.union(high)


def symmetric(radius: arb) -> arb:
    """Return the ball about zero that holds every number of a size up to a ball's."""
    largest = radius.abs_upper()
    return (-largest).union(largest)


def roomy(value: arb, share: arb = ROOM) -> arb:
    """Return a ball whose radius is larger by a share of itself."""
    return value + arb(0, (value.rad() * share).upper())


def inside(inner: Sequence[arb], outer: Sequence[arb]) -> bool:
    """Whether every ball lies in the interior of its counterpart."""
    return all(other.contains_interior(one) for one, other in zip(inner, outer, strict=True))


def largest(values: Iterable[arb]) -> arb:
    """Return an upper bound of the sizes of all numbers, an exact ball."""
    found = arb(0)
    for value in values:
        found = found.max(value.abs_upper())
    return found.upper()


def radius(value: arb) -> arb:
    """Return the radius of a ball, exact."""
    return value.rad()


def column(values: Sequence[arb]) -> arb_mat:
    """Return a vector as a matrix of one column."""
    return arb_mat(len(values), 1, list(values))


def exact_matrix(values: Matrix) -> arb_mat:
    """Return a matrix of floating-point numbers, each an exact ball."""
    rows, columns = values.shape
    return arb_mat(rows, columns, [arb(float(value)) for value in values.reshape(-1)])


def identity(size: int) -> arb_mat:
    """Return the identity, (size, size)."""
    return arb_mat(size, size, [arb(int(i == j)) for i in range(size) for j in range(size)])


def midpoints(matrix: arb_mat) -> Matrix:
    """Return the midpoints rounded to floating point, for everything that need not be rigorous."""
    entries = [float(value.mid()) for value in matrix.entries()]
    return np.array(entries).reshape(matrix.nrows(), matrix.ncols())


def row_sum_norm(matrix: arb_mat) -> arb:
    """Return an upper bound of the norm that belongs to the largest entry: the largest sum of a row's sizes."""
    return largest(sum((value.abs_upper() for value in row), start=arb(0)) for row in matrix.tolist())


Coefficient = TypeVar("Coefficient", arb, arb_mat)


def horner(coefficients: Sequence[Coefficient], at: arb) -> Coefficient:
    """Return the value of a polynomial, lowest power first, by Horner's rule."""
    total = coefficients[-1]
    for value in reversed(coefficients[:-1]):
        total = total * at + value
    return total


def fraction(value: arb) -> Fraction:
    """Return the midpoint of an exact ball as the rational number that it is."""
    mantissa, exponent = value.mid().man_exp()
    return Fraction(int(mantissa)) * Fraction(2) ** int(exponent)


def decimals(value: arb, digits: int = DIGITS) -> tuple[str, str]:
    """Write a ball as two decimal numbers, the lower rounded down and the upper rounded up."""
    return _decimal(fraction(value.lower()), digits, up=False), _decimal(fraction(value.upper()), digits, up=True)


def from_decimals(low: str, high: str) -> arb:
    """Return the smallest ball at the working precision that holds two decimal numbers and all between them."""
    return arb(low).union(arb(high))


def _decimal(value: Fraction, digits: int, up: bool) -> str:
    """Round a rational number to so many significant decimal digits, towards plus or minus infinity."""
    if value == 0:
        return "0"
    size = abs(value)
    exponent = max(len(str(size.numerator)) - len(str(size.denominator)) - digits, SMALLEST)
    scaled = value / Fraction(10) ** exponent
    whole = -((-scaled.numerator) // scaled.denominator) if up else scaled.numerator // scaled.denominator
    return f"{whole}e{exponent}"
