"""A domain as the proof needs it: its field, its guards with their slopes, its margin and its reset, on balls."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
from flint import arb, ctx

from amble.errors import InputError
from amble.hybrid import Domain, Transition
from amble.proof.explicit_field import ExplicitField
from amble.proof.margins import Margins
from amble.proof.step import Field, Part
from amble.proof.tape import Tape, expression, record

JUST_BEFORE = arb(2) ** -60
"""Share of a dead time at which a step ends before its end, so that it is known to lie within."""


@dataclass(frozen=True)
class Surface:
    """A guard with its slopes, over (t, x, p).

    Attributes:
        name: of what it is.
        values: tape of the function, its slope along x and its slope along t.
        sign: by which it is multiplied.
        dead_time: clock before which it is not looked at, s.
    """

    name: str
    values: Tape
    sign: int
    dead_time: float = 0.0

    @classmethod
    def of(cls, name: str, function: ca.Function, sign: int, dead_time: float = 0.0) -> Surface:
        """Differentiate a function of (t, x, p)."""
        t, x, p = _symbols(function)
        value = expression(function, [t, x, p])
        slopes = [value, ca.densify(ca.jacobian(value, x)), ca.densify(ca.jacobian(value, t))]
        return cls(name, record(ca.Function("surface", [t, x, p], slopes)), sign, dead_time)

    def at(self, clock: arb, state: Sequence[arb], parameters: Sequence[arb]) -> tuple[arb, list[arb], arb]:
        """Return g, g_x, g_t."""
        (value,), along, (drift,) = self.values.balls([clock], state, parameters)
        return self.sign * value, [self.sign * slope for slope in along], self.sign * drift


@dataclass(frozen=True, kw_only=True)
class Leg:
    """A domain as the proof needs it.

    Attributes:
        domain: itself.
        field: its vector field.
        exit: guard of that transition, the only one that leaves the domain.
        margins: that must stay positive.
        landing: that must be positive at the crossing.
        reset: tape of R, R_x by columns, R_t.
        parameters: the value of p.
        load: by which torques and contact forces in z are scaled, N (``LoopEquations``).
    """

    domain: Domain
    field: Field
    exit: Surface
    margins: Margins
    landing: Margins
    reset: Tape
    parameters: tuple[arb, ...]
    load: float = 1.0

    @classmethod
    def of(cls, domain: Domain, transition: Transition) -> Leg:
        """Prepare a domain.

        Raises:
            InputError: a function is compiled code, holds an operation without an enclosure, or the transition fires at
                the entry.
        """
        if transition.at_entry:
            raise InputError(f"domain '{domain.name}' may be left at its entry (simultaneous guards): no proof of that")
        field = ExplicitField.of(domain)
        guard, name = transition.guard, f"guard of '{transition.name}'"
        return cls(
            domain=domain,
            field=field,
            exit=Surface.of(name, guard, transition.direction, transition.dead_time),
            margins=_margins(domain),
            landing=Margins(),
            reset=reset_tape(transition.reset),
            parameters=tuple(arb(float(value)) for value in domain.parameters),
        )

    def rises(self, part: Part) -> tuple[arb, arb]:
        """Return the guard and its rate along the field in a part of a step."""
        value, along, drift = self.exit.at(part.during, part.box, self.parameters)
        return value, sum((slope * rate for slope, rate in zip(along, part.rate, strict=True)), start=drift)

    def cut(self, clock: arb, length: arb) -> arb:
        """Return a step length that passes no breakpoint, and stops just before the end of a dead time.

        Lengths have half of the precision's bits behind the point, so that clocks are sums without rounding.
        """
        length = _rounded_down(length.mid())
        before = _rounded_down(arb(self.exit.dead_time) * (1 - JUST_BEFORE))
        if clock < before and clock + length > before:
            length = (before - clock).mid()
        for mark in map(arb, self.domain.breakpoints):
            if clock < mark and clock + length > mark:
                length = (mark - clock).mid()
        return length

    def place(self, clock: arb) -> str:
        """Say where along the orbit something happens."""
        return f"in domain '{self.domain.name}' at clock {float(clock):.6g} s"


def _rounded_down(length: arb) -> arb:
    """Return the largest number with half of the precision's bits behind the point; a length below all stays."""
    grid = arb(2) ** (ctx.prec // 2)
    return (length * grid).floor().mid() / grid if length * grid > 1 else length.mid()


def reset_tape(reset: ca.Function) -> Tape:
    """Record a reset with its slopes in x, by columns, and in t."""
    t, x, p = _symbols(reset)
    after = expression(reset, [t, x, p])
    slopes = [after, ca.densify(ca.jacobian(after, x)), ca.densify(ca.jacobian(after, t))]
    return record(ca.Function("reset", [t, x, p], slopes))


def _margins(domain: Domain) -> Margins:
    """What keeps a motion in the domain of admissibility: the margin of the fall, and those that have a reason."""
    symbols = _symbols(domain.field)
    found = {} if domain.admissibility is None else {"admissibility": domain.admissibility}
    found |= {f"'{what}'": margin for what, margin in domain.margins.items()}
    if not found:
        return Margins()
    return Margins.of(
        [*symbols, ca.SX.sym("z", 0)], {name: expression(margin, symbols) for name, margin in found.items()}, {}
    )


def _symbols(function: ca.Function) -> list[ca.SX]:
    return [ca.SX.sym(name, function.numel_in(i)) for i, name in enumerate(("t", "x", "p"))]
