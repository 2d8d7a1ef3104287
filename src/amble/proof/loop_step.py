"""One verified step of a closed loop: a polynomial motion, and how far the true ones can be from it.

Shorthand of this file: x(s), z(s), V(s), Z(s) the polynomials of ``loop_expansion`` with defects R and G; w > 0 weights
of the states, w_v those of velocities; a picks the accelerations of z. Over a tube of states within reach w of x(s),
with the bounds of ``loop_bounds``,

    |f_x| w <= L w,    |M^-1 R|_a <= d w_v.                                                                     (1)

A motion from within e_0 w of x(0) stays within (e_0 + d s) exp(L s) w (Gronwall); where that is less than reach w up to
s = h, the tube holds it. Its variation misses V(s) by at most

    w_i s exp(L s) max_a |M^-1 (|G| + D_H |V| + D_M |Z|)|_a / w_a                                               (2)

in every column, with D_M and D_H the changes of M and H over the tube. What is wide in time enters bounds alone, never
the sets.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat, arb_poly

from amble.proof.arithmetic import column, horner, largest, midpoints, symmetric
from amble.proof.loop_bounds import Solver, Tube, perron, quotient, tube, weighted
from amble.proof.loop_expansion import Expansion, expand, motion_defect, sizes, variation_defect, vary
from amble.proof.loop_tapes import LoopTapes
from amble.proof.step import Step, StepError
from amble.types import Matrix, Vector

MOST_GROWTH = 3.0
"""Largest L h: Gronwall's factor is then below 21."""
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
        weights: w.
        factor: exp(L h).
        error: by how many w the motion from x(0) misses x(s) at most.
        share: of reach and slack that the motions really need.
    """

    tube: Tube
    solver: Solver
    weights: Vector
    factor: arb
    error: arb
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
        image=[end + symmetric(held.error * arb(float(w))) for end, w in zip(ends, held.weights, strict=True)],
        slope=_slope(loop, clock, motion, inverse, held, length),
        error=(held.error * arb(float(held.weights.max()))).upper(),
    )


def _held(loop: LoopTapes, clock: arb, motion: Expansion, inverse: arb_mat, box: Sequence[arb], length: arb) -> _Held:
    """Guess a tube and prove that it holds the motions from a box."""
    half, centre = loop.size // 2, [part[0] for part in motion.state]
    weights, sensitivity = _weights(loop, clock, motion)
    defect = sizes(inverse * column(motion_defect(loop, clock, motion, length)))
    start = quotient([(value - c).abs_upper() for value, c in zip(box, centre, strict=True)], weights)
    missed = quotient(defect.entries()[:half], weights[half:])
    reach = (GENEROUS[0] * (start + missed * length) + arb(2) ** -200).upper()
    slack = [
        (GENEROUS[1] * (reach * arb(float(s)) + value)).upper()
        for s, value in zip(sensitivity @ weights, defect.entries(), strict=True)
    ]
    around = [value.upper() for value in weighted(weights, reach).entries()], slack
    over = tube(loop, clock, motion, inverse, length, around)
    solver = Solver.of(over.rest)
    growth = _growth(solver(over.slope), weights)
    if not growth * length < MOST_GROWTH:
        raise StepError(f"the step is too long for the field's slope of {float(growth):.3g}/s")
    factor = (growth * length).exp()
    drift = quotient(solver(defect).entries()[:half], weights[half:])
    needed = (factor * (start + drift * length)).upper()
    solutions = solver(defect + over.slope * weighted(weights, needed)).entries()
    share = largest([needed / reach, *(a / b for a, b in zip(solutions, slack, strict=True))])
    if not share < 1:
        raise StepError("the motions are not proved to stay in the tube")
    return _Held(
        tube=over,
        solver=solver,
        weights=weights,
        factor=factor,
        error=(factor * drift * length).upper(),
        share=share,
    )


def _weights(loop: LoopTapes, clock: arb, motion: Expansion) -> tuple[Vector, Matrix]:
    """Return weights w of the states, and |dz/dx| at the start: not rigorous, and need not be."""
    half = loop.size // 2
    state, unknowns = [part[0] for part in motion.state], [part[0] for part in motion.unknowns]
    _, slope = loop.slopes([clock], state, loop.parameters, unknowns)
    answer = np.abs(np.linalg.solve(midpoints(motion.matrices[0]), midpoints(loop.of_slope(slope))))
    rates = np.vstack([np.hstack([np.zeros((half, half)), np.eye(half)]), answer[:half]])
    weights = perron(rates)
    return weights / weights[:half].max(), answer


def _growth(answer: arb_mat, weights: Vector) -> arb:
    """Return L of equation (1), from bounds of |M^-1 H|: rows q' = v, then accelerations."""
    half = answer.ncols() // 2
    positions, speeds = weights[:half], weights[half:]
    rates = (answer * weighted(weights)).entries()[:half]
    return largest([quotient(weighted(speeds).entries(), positions), quotient(rates, speeds)])


def _slope(loop: LoopTapes, clock: arb, motion: Expansion, inverse: arb_mat, held: _Held, length: arb) -> arb_mat:
    """Return dx(h)/dx(0) for every start of the box, by equation (2)."""
    half = loop.size // 2
    variation = vary(loop, clock, motion, round(VARIATION_SHARE * (len(motion.solution) - 1)))
    slope, answer = (horner([sizes(k) for k in rows], length) for rows in (variation.slope, variation.solution))
    changed = held.tube.slope_change * slope + held.tube.matrix_change * answer
    total = variation_defect(loop, clock, motion, variation, length) + changed * held.share
    missed = held.solver(sizes(inverse) * total).transpose().tolist()
    reach = [held.factor * length * quotient(values[:half], held.weights[half:]) for values in missed]
    ends = horner(variation.slope, length).tolist()
    widened = [
        [value + symmetric(extra * arb(float(w))) for value, extra in zip(row, reach, strict=True)]
        for row, w in zip(ends, held.weights, strict=True)
    ]
    return arb_mat(widened)
