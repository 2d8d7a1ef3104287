"""Motions of single points in 60 digits by another method than the proof's: extrapolated midpoint rules."""

from __future__ import annotations

from collections.abc import Callable, Sequence

from flint import arb

from amble.proof.arithmetic import working_precision
from amble.proof.leg import Leg

BITS = 200
NEWTON_STEPS = 3
Rate = Callable[[arb, list[arb]], list[arb]]


def moved(rate: Rate, clock: arb, start: Sequence[arb], length: arb, steps: int, columns: int = 16) -> list[arb]:
    """Return where a point comes to after a time: Gragg's midpoint rule extrapolated (Hairer, Norsett, Wanner, II.9).

    Args:
        rate: the field.
        clock: of the start, s.
        start: the point.
        length: s.
        steps: of equal length.
        columns: midpoint rules of 2, 4, 6, ... substeps that are extrapolated to zero in the square of their length.
    """
    with working_precision(BITS):
        state, big = [value.mid() for value in start], length / steps
        for number in range(steps):
            table: list[list[list[arb]]] = []
            for column in range(columns):
                row = [_midpoint(rate, clock + big * number, state, big, 2 * (column + 1))]
                for back in range(column):
                    ratio = arb(column + 1) / arb(column - back)
                    share = ratio * ratio - 1
                    pairs = zip(row[back], table[-1][back], strict=True)
                    row.append([(a + (a - b) / share).mid() for a, b in pairs])
                table.append(row)
            state = table[-1][-1]
    return state


def landed(leg: Leg, rate: Rate, start: Sequence[arb], clock: arb, steps: int, columns: int) -> tuple[arb, list[arb]]:
    """Return when a point crosses the guard that ends a domain, and where it enters the next one.

    Args:
        leg: the domain: its guard and its reset are taken from it.
        rate: the field.
        start: the point.
        clock: about when it crosses, s.
        steps: as in ``moved``, up to there.
        columns: as in ``moved``.
    """
    end = moved(rate, arb(0), start, clock, steps, columns)
    with working_precision(BITS):
        for _ in range(NEWTON_STEPS):
            value, along, drift = leg.exit.at(clock, end, leg.parameters)
            speed = sum((a * r for a, r in zip(along, rate(clock, end), strict=True)), start=drift)
            late = (value / speed).mid()
            end = moved(rate, clock, end, -late, 1, 6)
            clock = (clock - late).mid()
        image, _, _ = leg.reset.balls([clock], end, leg.parameters)
    return clock, [value.mid() for value in image]


def _midpoint(rate: Rate, clock: arb, start: list[arb], length: arb, count: int) -> list[arb]:
    small = (length / count).mid()
    before, here = start, _along(start, rate(clock, start), small)
    for number in range(1, count):
        before, here = here, _along(before, rate(clock + small * number, here), 2 * small)
    after = _along(before, rate(clock + length, here), small)
    return [((a + b) / 2).mid() for a, b in zip(here, after, strict=True)]


def _along(state: Sequence[arb], rate: Sequence[arb], length: arb) -> list[arb]:
    return [(value + length * change).mid() for value, change in zip(state, rate, strict=True)]
