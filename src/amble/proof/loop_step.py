"""One verified step of a closed loop: a polynomial motion, and how far the true ones can be from it.

Shorthand of this file: s the time since the start of a step; x(s), z(s), V(s), Z(s) the polynomials of
``loop_expansion`` with defects R and G; a picks the accelerations of z. Over a tube about x(s), with the bounds of
``loop_bounds``, entry by entry,

    |f_x| <= F,    |M^-1 R|_a <= d.                                                                             (1)

A motion from within e_0 of x(0) stays within exp(F s) (e_0 + s (0, d)) of x(s), for F has no negative entry; where that
is less than the tube's reach up to s = h, the tube holds it. Its variation misses V(s) by at most

    s exp(F s) (0, |M^-1 (|G| + D_H |V| + D_M |Z|)|_a),                                                         (2)

with D_M and D_H the changes of M and H over the tube. What is wide in time enters bounds alone, never the sets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import scipy.linalg
from flint import arb, arb_mat, arb_poly

from amble.proof.arithmetic import column, horner, largest, midpoints, symmetric
from amble.proof.loop_bounds import Solver, Tube, perron, quotient, tube, uppers, weighted
from amble.proof.loop_expansion import Expansion, expand, motion_defect, sizes, variation_defect, vary
from amble.proof.loop_tapes import LoopTapes
from amble.proof.step import Step, StepError
from amble.types import Matrix

MOST_GROWTH = 3.0
"""Largest L h with F w <= L w: exp(F h) is then below 21 in the norm of w."""
GENEROUS = 30, 20
"""By which reach and slack are taken larger than the first estimate: what is too much is taken back in (2)."""
VARIATION_SHARE = 0.8
"""Degree of Z as a share of that of z: a variation needs fewer digits than a motion, but at half the degree what it
misses is all that is wide in the derivative."""


@dataclass(frozen=True, kw_only=True)
class _Held:
    """Motions that are proved to stay in a tube.

    Attributes:
        tube: the bounds over it.
        solver: equation (1) of ``loop_bounds``.
        growth: exp(F h), exact bounds.
        error: by how much the motion from x(0) misses x(s) at most, a column.
        share: of reach and slack that the motions really need.
    """

    tube: Tube
    solver: Solver
    growth: arb_mat
    error: arb_mat
    share: arb


def loop_step(loop: LoopTapes, clock: arb, centre: Sequence[arb], box: Sequence[arb], length: arb, order: int) -> Step:
    """Advance a box with its centre by one step.

    Args:
        loop: the closed loop.
        clock: of the start, s.
        centre: a point of the box, exact.
        box: the starts.
        length: h, exact, s.
        order: degree of z.

    Raises:
        StepError: the bounds do not hold themselves.
    """
    motion = expand(loop, clock, centre, order)
    inverse = horner(motion.matrices, (length / 2).mid()).mid().inv().mid()
    held = _held(loop, clock, motion, inverse, box, length)
    ends = [arb_poly(part)(length) for part in motion.state]
    return Step(
        length=length,
        parts=held.tube.parts,
        centre=motion.state,
        image=[end + symmetric(missed) for end, missed in zip(ends, held.error.entries(), strict=True)],
        slope=_slope(loop, clock, motion, inverse, held, length),
        error=largest(held.error.entries()),
    )


def _held(loop: LoopTapes, clock: arb, motion: Expansion, inverse: arb_mat, box: Sequence[arb], length: arb) -> _Held:
    """Guess a tube and prove that it holds the motions from a box."""
    half, centre = loop.size // 2, [part[0] for part in motion.state]
    defect = uppers(sizes(inverse) * column(motion_defect(loop, clock, motion, length)))
    start = column([(value - c).abs_upper() for value, c in zip(box, centre, strict=True)])
    around = _guess(loop, clock, motion, midpoints(start), midpoints(defect), float(length))
    over = tube(loop, clock, motion, inverse, length, around)
    solver = Solver.of(over.rest)
    growth = _growth(arb_mat(solver(over.slope).tolist()[:half]), length)
    drift = _accelerating(solver(defect), half)
    needed = uppers(growth * (start + drift * length))
    solutions = solver(defect + over.slope * needed).entries()
    pairs = [*zip(needed.entries(), around[0], strict=True), *zip(solutions, around[1], strict=True)]
    share = largest([found / taken for found, taken in pairs])
    if not share < 1:
        raise StepError("the motions are not proved to stay in the tube")
    return _Held(tube=over, solver=solver, growth=growth, error=uppers(growth * drift * length), share=share)


def _guess(
    loop: LoopTapes, clock: arb, motion: Expansion, start: Matrix, defect: Matrix, length: float
) -> tuple[list[arb], list[arb]]:
    """Return reach and slack of a tube from |dz/dx| at the start of a step: not rigorous, and need not be."""
    half = loop.size // 2
    state, unknowns = [part[0] for part in motion.state], [part[0] for part in motion.unknowns]
    _, slope = loop.slopes([clock], state, loop.parameters, unknowns)
    answer = np.abs(np.linalg.solve(midpoints(motion.matrices[0]), midpoints(loop.of_slope(slope))))
    rates = np.vstack([np.hstack([np.zeros((half, half)), np.eye(half)]), answer[:half]])
    drift = np.vstack([np.zeros((half, 1)), defect[:half]])
    reach = GENEROUS[0] * scipy.linalg.expm(rates * length) @ (start + drift * length) + 2.0**-200
    slack = GENEROUS[1] * (answer @ reach + defect)
    return [arb(value) for value in reach.ravel().tolist()], [arb(value) for value in slack.ravel().tolist()]


def _growth(answer: arb_mat, length: arb) -> arb_mat:
    """Return bounds of exp(F h), from bounds of |M^-1 H|: rows q' = v, then accelerations."""
    half = answer.nrows()
    above = [[int(column == half + row) for column in range(2 * half)] for row in range(half)]
    rates = arb_mat([*above, *answer.tolist()])
    weights = perron(midpoints(rates))
    steepest = quotient((rates * weighted(weights)).entries(), weights)
    if not steepest * length < MOST_GROWTH:
        raise StepError(f"the step is too long for the field's slope of {float(steepest):.3g}/s")
    return uppers((rates * length).exp())


def _accelerating(bound: arb_mat, half: int) -> arb_mat:
    """Return (0, a) of bounds of unknowns, of which a are the accelerations, in every column."""
    return arb_mat([*[[0] * bound.ncols()] * half, *bound.tolist()[:half]])


def _slope(loop: LoopTapes, clock: arb, motion: Expansion, inverse: arb_mat, held: _Held, length: arb) -> arb_mat:
    """Return dx(h)/dx(0) for every start of the box, by equation (2)."""
    variation = vary(loop, clock, motion, round(VARIATION_SHARE * (len(motion.solution) - 1)))
    slope, answer = (horner([sizes(k) for k in rows], length) for rows in (variation.slope, variation.solution))
    changed = held.tube.slope_change * slope + held.tube.matrix_change * answer
    total = variation_defect(loop, clock, motion, variation, length) + changed * held.share
    missed = held.solver(uppers(sizes(inverse) * total))
    reach = held.growth * _accelerating(missed, loop.size // 2) * length
    ends = zip(horner(variation.slope, length).entries(), reach.entries(), strict=True)
    return arb_mat(loop.size, loop.size, [value + symmetric(extra) for value, extra in ends])
