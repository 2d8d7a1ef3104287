"""Power series in time of a motion and of its first variation, coefficient by coefficient.

With x' = f(t, x) and V' = f_x(t, x) V the coefficients x_k, V_k of s^k, s = t - t_0, obey

    (k + 1) x_(k+1) = f_k,        (k + 1) V_(k+1) = sum_j (f_x)_j V_(k-j),                                      (1)

where f_k and (f_x)_j are the coefficients of f and f_x along the series. In balls they hold the coefficients of every
motion that passes the ball x_0 at a time in the ball t_0.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Protocol

from flint import arb, arb_mat, arb_series, ctx

from amble.proof.tape import UndecidedError, Value

Coefficients = list[list[arb]]
"""For every power the n_x coefficients."""


class Smooth(Protocol):
    """A vector field that can be expanded."""

    @property
    def size(self) -> int:
        """Number of states."""

    def motion(self, clock: arb, state: Sequence[arb], order: int) -> Coefficients:
        """Return x_0 ... x_order."""

    def slopes(self, clock: arb, motion: Coefficients) -> list[arb_mat]:
        """Return the coefficients of f_x along x_0 ... x_(m), for powers up to m."""


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
    """Return a coefficient of a series, or of a constant.

    Raises:
        UndecidedError: the series is not known that far; python-flint gives 0.
    """
    if isinstance(value, arb_series):
        if power >= value.prec:
            raise UndecidedError("a series of the model is not known as far as is asked")
        return value[power]
    return value if power == 0 else arb(0)


def along(motion: Coefficients, count: int) -> list[arb_series]:
    """Return the motion of every state as a series."""
    return [series([powers[i] for powers in motion[:count]], count) for i in range(len(motion[0]))]


def series(coefficients: Sequence[arb], count: int) -> arb_series:
    """Return the power series of the first coefficients."""
    ctx.cap = max(ctx.cap, count)
    return arb_series(list(coefficients[:count]), prec=count)
