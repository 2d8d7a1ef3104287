"""Curves in polynomial pieces: fitted to the accuracy that is asked for, split where a function has a corner."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.polynomial import chebyshev

from amble.errors import WorkError
from amble.types import Matrix, NodeValues, Vector, frozen

ORDER = 11
"""Of every piece."""

MOST_PIECES = 64

MOST_LOOKS = 4000
"""The most pieces that are tried."""

NARROWEST = 1e-10
"""Share of the whole below which a piece is not halved any more: there the function jumps."""

CLOSE, CLOSEST, FINER = 1e-3, 1e-7, 0.2
"""Pieces between these shares of the whole are there for a corner alone: they must meet the function to this share of
the accuracy, so that the corner is located to what the long pieces beside it hardly see."""

NODES = np.cos(np.pi * (np.arange(ORDER + 1)[::-1] + 0.5) / (ORDER + 1))
BETWEEN = np.linspace(-1.0, 1.0, 2 * ORDER + 3)
SAMPLES = np.concatenate([NODES, BETWEEN])
"""Where a piece is sampled, on [-1, 1]: at Chebyshev nodes to fit, between them and at the ends, where a corner
hides else, to see whether that is enough."""

TO_COEFFICIENTS = np.linalg.inv(chebyshev.chebvander(NODES, ORDER))
TO_POWERS = np.stack(
    [np.pad(chebyshev.cheb2poly(row), (0, ORDER + 1 - np.size(chebyshev.cheb2poly(row)))) for row in np.eye(ORDER + 1)],
    axis=1,
)

FAR = 1e30
"""Where pieces begin that are never reached, s."""

Curve = Callable[[Vector], Matrix]
"""Times (k,), s -> values (k, rows). ``fitted`` always asks for as many times as there are ``SAMPLES``."""


@dataclass(frozen=True, kw_only=True)
class Pieces:
    """Rows of curves in polynomial pieces.

    Attributes:
        breaks: ends of the pieces, ascending, (n + 1,), s.
        coefficients: of the powers of xi, which runs from -1 to 1 over a piece, (n, rows, ORDER + 1).
    """

    breaks: Vector
    coefficients: NodeValues

    @property
    def count(self) -> int:
        """Number n of pieces."""
        return len(self.coefficients)

    def __call__(self, times: Vector) -> tuple[Matrix, Matrix]:
        """Return values and rates at times, (k, rows) each; outside, the first and last pieces go on."""
        times = np.asarray(times, dtype=np.float64)
        place = np.clip(np.searchsorted(self.breaks, times, side="right") - 1, 0, self.count - 1)
        half = 0.5 * np.diff(self.breaks)[place]
        xi = (times - self.breaks[place]) / half - 1.0
        powers = xi[:, None] ** np.arange(ORDER + 1)
        slopes = np.arange(1, ORDER + 1) * powers[:, :-1]
        chosen = self.coefficients[place]
        values = np.einsum("krc,kc->kr", chosen, powers)
        return values, np.einsum("krc,kc->kr", chosen[:, :, 1:], slopes) / half[:, None]

    def cut(self, breaks: Vector) -> Pieces:
        """Return the same curves with cuts at further times inside, so that they can be put beside others."""
        inside = breaks[(breaks > self.breaks[0]) & (breaks < self.breaks[-1])]
        ends = np.union1d(self.breaks, inside)
        found = [piece(self(0.5 * (a + b) + 0.5 * (b - a) * SAMPLES)[0])[0] for a, b in itertools.pairwise(ends)]
        return Pieces(breaks=frozen(ends), coefficients=frozen(np.array(found)))


def fitted(curve: Curve, start: float, end: float, accuracy: float) -> Pieces:
    """Fit pieces to a function that is smooth but for finitely many corners and jumps.

    A piece that misses the function is halved, towards a corner again and again, until the corner is located so well
    that it is not seen any more; pieces are then cut there and nowhere else on the way.

    Args:
        curve: the function.
        start: of the first piece, s.
        end: of the last, s.
        accuracy: largest error at the sampled times, in the unit of the values.

    Raises:
        WorkError: the function is not finite, or has so many corners that ``MOST_PIECES`` do not do.
    """
    breaks, whole, looks = [start, end], end - start, itertools.count(1)

    def met(a: float, b: float) -> bool:
        if next(looks) > MOST_LOOKS:
            raise WorkError(f"a curve is not met to {accuracy:g} by polynomial pieces, however they are cut")
        return _sampled(curve, a, b)[1] <= accuracy * (FINER if CLOSEST < (b - a) / whole < CLOSE else 1.0)

    while True:
        cuts = [cut for a, b in itertools.pairwise(breaks) for cut in _cuts(met, a, b, whole)]
        if not cuts:
            break
        breaks = sorted({*breaks, *cuts})
        if len(breaks) > MOST_PIECES + 1:
            raise WorkError(f"a curve takes more than {MOST_PIECES} polynomial pieces to {accuracy:g}")
    pieces = [_sampled(curve, a, b)[0] for a, b in itertools.pairwise(breaks)]
    return Pieces(breaks=frozen(breaks), coefficients=frozen(np.array(pieces)))


def _cuts(met: Callable[[float, float], bool], a: float, b: float, whole: float) -> list[float]:
    """Where to cut an interval; nothing where one piece meets the function."""
    narrow = b - a <= 2.0 * NARROWEST * whole
    if met(a, b):
        return []
    middle = 0.5 * (a + b)
    if narrow:
        return [middle] if b - a > NARROWEST * whole else []
    halves = _cuts(met, a, middle, whole) + _cuts(met, middle, b, whole)
    return halves or [middle]


def piece(values: Matrix) -> tuple[Matrix, float]:
    """Fit one piece to the values at its ``SAMPLES``, (k, rows).

    Returns:
        Its coefficients, (rows, ORDER + 1), and its largest error between the nodes.

    Raises:
        WorkError: a value is not finite.
    """
    if not np.all(np.isfinite(values)):
        raise WorkError("a curve that is to be written in polynomial pieces is not finite")
    at_nodes, between = values[: NODES.size], values[NODES.size :]
    series = TO_COEFFICIENTS @ at_nodes
    error = np.abs(chebyshev.chebval(BETWEEN, series).T - between).max(initial=0.0)
    return (TO_POWERS @ series).T, float(error)


def _sampled(curve: Curve, a: float, b: float) -> tuple[Matrix, float]:
    return piece(np.asarray(curve(0.5 * (a + b) + 0.5 * (b - a) * SAMPLES)))


def padded(pieces: Pieces, count: int) -> tuple[Vector, NodeValues]:
    """Return starts (count,) and half lengths (count,) stacked, and coefficients, with pieces that are never reached.

    Args:
        pieces: the pieces.
        count: how many there shall be.
    """
    more = count - pieces.count
    starts = np.concatenate([pieces.breaks[:-1], np.full(more, FAR)])
    halves = np.concatenate([0.5 * np.diff(pieces.breaks), np.ones(more)])
    blank = np.zeros((more, *pieces.coefficients.shape[1:]))
    return frozen(np.stack([starts, halves])), frozen(np.concatenate([pieces.coefficients, blank]))


def evaluated(places: ca.SX, coefficients: ca.SX, rows: int, time: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Write values and rates of pieces as expressions, (rows,) each; outside, the first and last pieces go on.

    Args:
        places: starts and half lengths as ``padded`` returns them, (2, n).
        coefficients: (n rows (ORDER + 1),) in C order.
        rows: number of curves.
        time: s.
    """
    count = places.shape[1]
    chosen = ca.SX(rows * (ORDER + 1), 1)
    xi, half = ca.SX(0), ca.SX(0)
    for number, block in enumerate(ca.vertsplit(coefficients, rows * (ORDER + 1))):
        begun = ca.SX(1) if number == 0 else time >= places[0, number]
        over = ca.SX(0) if number == count - 1 else time >= places[0, number + 1]
        here = begun * (1 - over)
        chosen += here * block
        xi += here * ((time - places[0, number]) / places[1, number] - 1.0)
        half += here * places[1, number]
    table = ca.reshape(chosen, ORDER + 1, rows).T
    value, slope = table[:, ORDER], ca.SX(rows, 1)
    for power in range(ORDER - 1, -1, -1):
        slope = slope * xi + value
        value = value * xi + table[:, power]
    return value, slope / half
