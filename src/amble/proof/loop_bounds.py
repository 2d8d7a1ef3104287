"""Bounds of a closed loop's equations over a tube about a polynomial motion, and of what their solutions can miss.

With C an approximate inverse of M, N = |1 - C M| and weights omega > 0 with N omega <= kappa omega,

    |M^-1 r| <= (1 + N + ... + N^m) |C r| + omega kappa / (1 - kappa) max_j (N^m |C r|)_j / omega_j.            (1)

A step is cut into pieces for its bounds; a piece's box holds all states x(s) + e, |e| <= reach, and unknowns
z(s) + f, |f| <= slack. Along such e and f the entries of M and H change by at most their coefficient of
sigma at x + sigma e, z + sigma f over the box (mean value).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_poly

from amble.proof.arithmetic import identity, largest, midpoints, symmetric
from amble.proof.loop_expansion import Expansion, placed_sizes, sizes
from amble.proof.loop_tapes import LoopTapes
from amble.proof.step import Part, StepError
from amble.proof.tape import NOT_ENCLOSED
from amble.proof.taylor import coefficient, series
from amble.types import Matrix, Vector

PIECES = (8, 16, 32)
"""How often a step is cut; more where M is not proved to be invertible."""
KAPPA = 0.5
NEUMANN = 6
"""m of equation (1): what remains couples all unknowns, and is below KAPPA^m."""
ITERATIONS = 40


@dataclass(frozen=True, kw_only=True)
class Tube:
    """What holds over a step.

    Attributes:
        parts: of the step, in order.
        rest: bounds of |1 - C M|, exact.
        slope: of |C H|.
        matrix_change: of how much M changes along e.
        slope_change: of how much H changes along e and f.
    """

    parts: tuple[Part, ...]
    rest: arb_mat
    slope: arb_mat
    matrix_change: arb_mat
    slope_change: arb_mat


@dataclass(frozen=True)
class Solver:
    """Equation (1).

    Attributes:
        rest: N.
        omega: weights.
        kappa: their bound.
    """

    rest: arb_mat
    omega: Vector
    kappa: arb

    @classmethod
    def of(cls, rest: arb_mat) -> Solver:
        """Choose weights for bounds of |1 - C M|.

        Raises:
            StepError: M is not proved to be invertible.
        """
        omega = perron(midpoints(rest))
        kappa = quotient((rest * weighted(omega)).entries(), omega)
        if not kappa < KAPPA:
            raise StepError(f"M is not proved to be invertible: |1 - C M| is {float(kappa):.3g}")
        return cls(rest, omega, kappa)

    def __call__(self, bound: arb_mat) -> arb_mat:
        """Return bounds of |M^-1 r| from those of |C r|, for every column."""
        total = last = bound
        for _ in range(NEUMANN):
            last = uppers(self.rest * last)
            total = total + last
        share = self.kappa / (1 - self.kappa)
        tops = [share * quotient(values, self.omega) for values in last.transpose().tolist()]
        return uppers(total + weighted(self.omega) * arb_mat(1, len(tops), tops))


def tube(
    loop: LoopTapes,
    clock: arb,
    motion: Expansion,
    inverse: arb_mat,
    length: arb,
    around: tuple[Sequence[arb], Sequence[arb]],
) -> Tube:
    """Bound the equations over a step; in more pieces where M is not invertible over some.

    Args:
        loop: the equations.
        clock: of the start, s.
        motion: the polynomials.
        inverse: C, exact.
        length: h, s.
        around: reach and slack, exact.

    Raises:
        StepError: M is not proved to be invertible.
    """
    reason = ""
    for count in PIECES:
        try:
            found = _in_pieces(loop, clock, motion, inverse, length, around, count)
        except NOT_ENCLOSED as error:
            reason = str(error)
            continue
        rest = midpoints(found.rest)
        if np.all(np.isfinite(rest)) and np.abs(np.linalg.eigvals(rest)).max() < 0.8 * KAPPA:
            return found
        reason = "M is not proved to be invertible"
    raise StepError(f"{reason} over a step of {float(length):.3g} s")


def _in_pieces(
    loop: LoopTapes,
    clock: arb,
    motion: Expansion,
    inverse: arb_mat,
    length: arb,
    around: tuple[Sequence[arb], Sequence[arb]],
    count: int,
) -> Tube:
    half, n, m = loop.size // 2, loop.unknowns, loop.size
    polynomials = [[arb_poly(part) for part in rows] for rows in (motion.state, motion.unknowns)]
    totals, parts = list[arb_mat](), list[Part]()
    for number in range(count):
        span = (length * number / count).union(length * (number + 1) / count)
        box, found = (
            [part(span) + symmetric(extra) for part, extra in zip(rows, extras, strict=True)]
            for rows, extras in zip(polynomials, around, strict=True)
        )
        x, z = (
            [series([value, symmetric(extra)], 2) for value, extra in zip(values, extras, strict=True)]
            for values, extras in zip((box, found), around, strict=True)
        )
        matrix, slope = loop.slopes([series([clock + span], 2)], x, loop.parameters, z)
        bounds = [
            sizes(inverse * loop.of_matrix(matrix) - identity(n)),
            sizes(inverse * loop.of_slope(slope)),
            placed_sizes(n, n, loop.matrix_places, [coefficient(value, 1) for value in matrix]),
            placed_sizes(n, m, loop.slope_places, [coefficient(value, 1) for value in slope]),
        ]
        totals = [_larger(one, other) for one, other in zip(totals, bounds, strict=True)] if totals else bounds
        parts.append(Part(during=clock + span, box=box, rate=[*box[half:], *found[:half]], solution=found))
    rest, along, matrix_change, slope_change = totals
    return Tube(parts=tuple(parts), rest=rest, slope=along, matrix_change=matrix_change, slope_change=slope_change)


def perron(matrix: Matrix) -> Vector:
    """Return a positive vector close to the one that a matrix without negative entries stretches most."""
    vector = np.ones(len(matrix))
    floor = 1e-4 * np.abs(matrix).max()
    for _ in range(ITERATIONS):
        vector = matrix @ vector + (floor * vector.mean() + 0.1 * vector)
        vector = vector / vector.max()
    return vector


def quotient(values: Sequence[arb], weights: Vector) -> arb:
    """Return an upper bound of the largest value over its weight, exact."""
    return largest(value / arb(float(w)) for value, w in zip(values, weights, strict=True))


def weighted(weights: Vector) -> arb_mat:
    """Return weights as a column, exact."""
    return arb_mat(len(weights), 1, [arb(float(w)) for w in weights])


def uppers(matrix: arb_mat) -> arb_mat:
    """Return upper bounds of all entries, exact."""
    return arb_mat(matrix.nrows(), matrix.ncols(), [value.upper() for value in matrix.entries()])


def _larger(one: arb_mat, other: arb_mat) -> arb_mat:
    """Return the larger of two exact matrices, entry by entry; what cannot be compared is as bad as infinite."""
    pairs = zip(one.entries(), other.entries(), strict=True)
    return arb_mat(one.nrows(), one.ncols(), [b if b > a else a if a >= b else arb("inf") for a, b in pairs])
