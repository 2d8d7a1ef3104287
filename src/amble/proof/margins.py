"""Margins that must stay positive along an orbit, with the smallest bound that was proved of each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
from flint import arb

from amble.proof.arithmetic import roomy
from amble.proof.errors import ProofError
from amble.proof.step import Part
from amble.proof.tape import Tape, record


class MarginError(ProofError):
    """A margin may fail on what was enclosed; a shorter step encloses less."""


@dataclass(frozen=True, kw_only=True)
class Margins:
    """Functions of (t, x, p, z) that must be positive; z solves the equations of the field, where it solves any.

    Attributes:
        names: of what they are the margins.
        rising: whether a margin may start at zero: it must then rise until it is known to be above zero.
        values: tape of all margins, and of the rates of all (zero where they do not start at zero).
    """

    names: tuple[str, ...] = ()
    rising: tuple[bool, ...] = ()
    values: Tape | None = None

    @classmethod
    def of(cls, symbols: Sequence[ca.SX], margins: dict[str, ca.SX], rising: dict[str, tuple[ca.SX, ca.SX]]) -> Margins:
        """Take expressions.

        Args:
            symbols: t, x, p, z.
            margins: name -> margin.
            rising: name -> margin that may start at zero, and its rate.
        """
        values = [*margins.values(), *(value for value, _ in rising.values())]
        rates = [*([ca.SX(0)] * len(margins)), *(rate for _, rate in rising.values())]
        results = [ca.densify(ca.vertcat(*part, ca.SX(0, 1))) for part in (values, rates)]
        return cls(
            names=(*margins, *rising),
            rising=(*([False] * len(margins)), *([True] * len(rising))),
            values=record(ca.Function("margins", list(symbols), ca.cse(results))),
        )

    def watch(self, room: arb) -> Watch:
        """Start at the entry of a domain.

        Args:
            room: share of its radius by which every margin is widened.
        """
        return Watch(self, room)


class Watch:
    """Margins along one pass through a domain.

    Attributes:
        margins: what is watched.
        room: share of its radius by which every margin is widened.
        lowest: the smallest lower bound so far, of those that were above zero.
    """

    def __init__(self, margins: Margins, room: arb) -> None:
        self.margins, self.room = margins, room
        self.lowest: list[arb | None] = [None] * len(margins.names)
        self._rising = list(margins.rising)

    @property
    def bounds(self) -> dict[str, arb]:
        """Name -> smallest lower bound, of those that were above zero."""
        found = zip(self.margins.names, self.lowest, strict=True)
        return {name: low for name, low in found if low is not None}

    def require(self, parts: Sequence[Part], parameters: Sequence[arb]) -> None:
        """Ask that all margins hold all along the parts that come next; where one may fail, nothing is noted.

        Raises:
            MarginError: one that may fail, and its bound.
        """
        tape, lowest, rising = self.margins.values, list(self.lowest), list(self._rising)
        if tape is None:
            return
        for part in parts:
            values, rates = tape.balls([part.during], part.box, parameters, part.solution)
            for number, (found, rate) in enumerate(zip(values, rates, strict=True)):
                value = roomy(found, self.room)
                rising[number] = rising[number] and bool(rate > 0)
                if value > 0:
                    low, known = value.lower(), lowest[number]
                    lowest[number] = low if known is None or low < known else known
                elif not rising[number]:
                    name, known_above = self.margins.names[number], value.lower().str(4, radius=False)
                    raise MarginError(f"the margin of {name} is only known to be above {known_above}")
        self.lowest, self._rising = lowest, rising
