"""A vector field given by expressions of clock and state."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
from flint import arb, arb_mat

from amble.hybrid import Domain
from amble.proof.step import Part, Step, take_step
from amble.proof.tape import Tape, expression, record
from amble.proof.taylor import Coefficients, along, coefficient, series


@dataclass(frozen=True)
class ExplicitField:
    """A field given by expressions.

    Attributes:
        rate: the tape of f.
        gradient: the tape of f_x, dense by columns.
        parameters: the value of p.
        size: number of states.
    """

    rate: Tape
    gradient: Tape
    parameters: tuple[arb, ...]
    size: int

    @classmethod
    def of(cls, domain: Domain) -> ExplicitField:
        """Take the field of a domain. Its slope is that of its expressions: ``Domain.jacobian`` is not believed.

        Raises:
            InputError: it is compiled code, or holds an operation that has no enclosure.
        """
        t, x = ca.SX.sym("t"), ca.SX.sym("x", domain.state_size)
        p = ca.SX.sym("p", domain.parameters.size)
        rate = expression(domain.field, [t, x, p])
        return cls(
            rate=record(ca.Function("rate", [t, x, p], [rate])),
            gradient=record(ca.Function("slope", [t, x, p], [ca.densify(ca.jacobian(rate, x))])),
            parameters=tuple(arb(float(value)) for value in domain.parameters),
            size=domain.state_size,
        )

    @property
    def governing(self) -> tuple[Tape, ...]:
        """The expressions that determine the motion, over (t, x, p)."""
        return (self.rate,)

    def motion(self, clock: arb, state: Sequence[arb], order: int) -> Coefficients:
        """Expand the motion by equation (1) of ``taylor``."""
        found = [list(state)]
        for power in range(order):
            clocks = [series([clock, arb(1)], power + 1)]
            (rate,) = self.rate(clocks, along(found, power + 1), self.parameters)
            found.append([coefficient(value, power) / (power + 1) for value in rate])
        return found

    def slopes(self, clock: arb, motion: Coefficients) -> list[arb_mat]:
        """Expand f_x along the motion."""
        count = len(motion)
        (entries,) = self.gradient([series([clock, arb(1)], count)], along(motion, count), self.parameters)
        return [
            arb_mat(self.size, self.size, [coefficient(value, power) for value in entries]).transpose()
            for power in range(count)
        ]

    def part(self, during: arb, box: Sequence[arb]) -> Part:
        """Return what holds in a box of states at some clocks."""
        (rate,) = self.rate.balls([during], box, self.parameters)
        return Part(during=during, box=list(box), rate=rate, solution=[])

    def slope(self, part: Part) -> arb_mat:
        """Return balls that hold f_x there."""
        return self.slopes(part.during, [part.box])[0]

    def drift(self, part: Part) -> list[arb]:
        """Return balls that hold f_t there."""
        state = [series([value, arb(0)], 2) for value in part.box]
        (rate,) = self.rate([series([part.during, arb(1)], 2)], state, self.parameters)
        return [coefficient(value, 1) for value in rate]

    def polynomial(self, clock: arb, centre: Sequence[arb], order: int) -> list[list[arb]]:
        """Return every state's coefficients of the motion from a point."""
        return [list(row) for row in zip(*self.motion(clock, centre, order), strict=True)]

    def step(self, clock: arb, centre: Sequence[arb], box: Sequence[arb], length: arb, order: int) -> Step:
        """Advance a box; see ``step.take_step``."""
        return take_step(self, clock, centre, box, length, order)
