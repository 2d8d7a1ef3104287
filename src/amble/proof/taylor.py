"""Power series in time of a motion and of its first variation, coefficient by coefficient.

With x' = f(t, x) and V' = f_x(t, x) V the coefficients x_k, V_k of s^k, s = t - t_0, obey

    (k + 1) x_(k+1) = f_k,        (k + 1) V_(k+1) = sum_j (f_x)_j V_(k-j),                                      (1)

where f_k and (f_x)_j are the coefficients of f and f_x along the series. In balls they hold the coefficients of every
motion that passes the ball x_0 at a time in the ball t_0.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import casadi as ca
from flint import arb, arb_mat, arb_series, ctx

from amble.hybrid import Domain
from amble.proof.tape import Tape, Value, record
from amble.stability.derivatives import field_jacobian

Coefficients = list[list[arb]]
"""For every power the n_x coefficients."""


class Field(Protocol):
    """A vector field that can be expanded."""

    @property
    def size(self) -> int:
        """Number of states."""

    @property
    def tapes(self) -> tuple[Tape, ...]:
        """The expressions that it is made of."""

    def motion(self, clock: arb, state: Sequence[arb], order: int) -> Coefficients:
        """Return x_0 ... x_order."""

    def slopes(self, clock: arb, motion: Coefficients) -> list[arb_mat]:
        """Return the coefficients of f_x along x_0 ... x_(m), for powers up to m."""


@dataclass(frozen=True)
class ExplicitField:
    """A field given by expressions.

    Attributes:
        rate: the tape of f.
        slope: the tape of f_x, dense by columns.
        parameters: the value of p.
        size: number of states.
    """

    rate: Tape
    slope: Tape
    parameters: tuple[arb, ...]
    size: int

    @classmethod
    def of(cls, domain: Domain) -> ExplicitField:
        """Take the field of a domain.

        Raises:
            InputError: it is compiled code, or holds an operation that has no enclosure.
        """
        rate = record(domain.field)  # first: compiled code is refused here, in a sentence
        t, x = ca.SX.sym("t"), ca.SX.sym("x", domain.state_size)
        p = ca.SX.sym("p", domain.parameters.size)
        jacobian = ca.densify(field_jacobian(domain)(t, x, p))
        return cls(
            rate=rate,
            slope=record(ca.Function("slope", [t, x, p], [jacobian])),
            parameters=tuple(arb(float(value)) for value in domain.parameters),
            size=domain.state_size,
        )

    @property
    def tapes(self) -> tuple[Tape, ...]:
        """The expressions that it is made of."""
        return self.rate, self.slope

    def motion(self, clock: arb, state: Sequence[arb], order: int) -> Coefficients:
        """Expand the motion by equation (1)."""
        found = [list(state)]
        for power in range(order):
            (rate,) = self.rate([_time(clock, power + 1)], _series(found, power + 1), self.parameters)
            found.append([coefficient(value, power) / (power + 1) for value in rate])
        return found

    def slopes(self, clock: arb, motion: Coefficients) -> list[arb_mat]:
        """Expand f_x along the motion."""
        count = len(motion)
        (entries,) = self.slope([_time(clock, count)], _series(motion, count), self.parameters)
        return [
            arb_mat(self.size, self.size, [coefficient(value, power) for value in entries]).transpose()
            for power in range(count)
        ]


def variation(slopes: Sequence[arb_mat], start: arb_mat, order: int) -> list[arb_mat]:
    """Return V_0 ... V_order of equation (1) from V_0 and the coefficients of f_x, of which order are needed."""
    found = [start]
    for power in range(order):
        total = slopes[0] * found[power]
        for j in range(1, power + 1):
            total = total + slopes[j] * found[power - j]
        found.append(total / arb(power + 1))
    return found


def coefficient(value: Value, power: int) -> arb:
    """Return a coefficient of a series, or of a constant."""
    if isinstance(value, arb_series):
        return value[power]
    return value if power == 0 else arb(0)


def _series(motion: Coefficients, count: int) -> list[arb_series]:
    ctx.cap = max(ctx.cap, count)
    return [arb_series([powers[i] for powers in motion[:count]], prec=count) for i in range(len(motion[0]))]


def _time(clock: arb, count: int) -> arb_series:
    ctx.cap = max(ctx.cap, count)
    return arb_series([clock, arb(1)][:count], prec=count)
