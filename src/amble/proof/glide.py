"""A motion in high precision through a domain, not enclosed: where a search needs a point and no proof."""

from __future__ import annotations

from collections.abc import Sequence

from flint import arb, ctx

from amble.proof.arithmetic import horner
from amble.proof.errors import ProofError
from amble.proof.leg import Leg
from amble.proof.step import MOST_STEPS, Field
from amble.proof.tape import NOT_ENCLOSED

NEWTON_STEPS = 20
CAUTION = 0.5
"""Share of the length at which a last term would be the tolerance."""
LONGEST = 1 / 16
"""Share of the time known to be spent in a domain that a step takes at most. A motion that is a polynomial, as
a flight, has no last terms: a step over all of it would end behind the guard without having been before it."""


def wished_length(field: Field, clock: arb, centre: Sequence[arb], order: int, tolerance: float) -> arb:
    """Return a step length whose last terms are below a tolerance."""
    return _length(field.polynomial(clock, centre, order), tolerance)


def crossing(leg: Leg, clock: arb, polynomial: Sequence[Sequence[arb]], start: arb) -> arb | None:
    """Newton for the time at which a polynomial motion meets the guard that ends a domain; None where it fails."""
    at = start
    for _ in range(NEWTON_STEPS):
        value, rate = leg.rises(leg.field.part(clock + at, _at(polynomial, at)))
        change = (value / rate).mid()
        at = (at - change).mid()
        if not at.is_finite():
            return None
        if abs(change) <= abs(at) * arb(2) ** -min(100, 3 * ctx.prec // 4):
            return at
    return None


def passed(
    leg: Leg, start: Sequence[arb], order: int, tolerance: float, duration: float, most: int = MOST_STEPS
) -> list[arb]:
    """Return where a point enters the next domain.

    Args:
        leg: the domain.
        start: the point, exact.
        order: of the Taylor polynomials.
        tolerance: of their last terms.
        duration: about the time that it spends in the domain, s.
        most: steps.

    Raises:
        ProofError: it does not reach the guard, or has no Taylor series on the way.
    """
    clock, state, longest = arb(0), list(start), arb(LONGEST * duration)
    below = _below(leg, clock, state)
    for _ in range(most):
        polynomial = _expanded(leg, clock, state, order)
        length = leg.cut(clock, min(longest, _length(polynomial, tolerance)))
        after = _at(polynomial, length)
        still = _below(leg, clock + length, after)
        if below and not still and not clock + length <= arb(leg.exit.dead_time):
            end = crossing(leg, clock, polynomial, length)
            if end is not None and arb(0) < end <= length:
                image, _, _ = leg.reset.balls([clock + end], _at(polynomial, end), leg.parameters)
                return [value.mid() for value in image]
        clock, state, below = (clock + length).mid(), after, still
    raise ProofError(f"{most} steps were not enough {leg.place(clock)}")


def _expanded(leg: Leg, clock: arb, state: Sequence[arb], order: int) -> list[list[arb]]:
    """Return the coefficients of the motion from a point.

    Raises:
        ProofError: a switch cannot be decided there, or they are no numbers.
    """
    try:
        found = leg.field.polynomial(clock, state, order)
    except NOT_ENCLOSED as error:
        raise ProofError(f"{error} {leg.place(clock)}") from None
    if not all(value.is_finite() for row in found for value in row):
        raise ProofError(f"the motion has no Taylor series {leg.place(clock)}")
    return found


def _below(leg: Leg, clock: arb, state: Sequence[arb]) -> bool:
    return bool(leg.exit.at(clock, state, leg.parameters)[0].mid() < 0)


def _length(polynomial: Sequence[Sequence[arb]], tolerance: float) -> arb:
    """Return a share of the largest length at which no last term is above the tolerance, s."""
    found = []
    for row in polynomial:
        size = max(float(abs(row[-1]).mid()), tolerance**2)
        found.append((tolerance / size) ** (1.0 / (len(row) - 1)))
    return arb(CAUTION * min(found))


def _at(polynomial: Sequence[Sequence[arb]], at: arb) -> list[arb]:
    return [horner([value.mid() for value in row], at).mid() for row in polynomial]
