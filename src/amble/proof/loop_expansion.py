"""Polynomials close to a motion of a closed loop and to its first variation, with enclosures of what they miss.

Shorthand of this file: s the time since the start of a step; z(s) and Z(s) polynomials with exact
coefficients, whatever they are; x(s) and V(s) the integrals of (v, S z) and (V_v, S Z) from a point c and from 1. With
M, b, H along x and z,

    R = M z - b,        G = M Z + H V                                                                           (1)

vanish for the motion and its variation. Both are smooth in s: their Taylor coefficients at 0 and a coefficient at every
time of the step enclose them (Lagrange's remainder), and no solution of an equation enters that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import comb

from flint import arb, arb_mat, arb_poly

from amble.proof.arithmetic import between, identity
from amble.proof.loop_tapes import LoopTapes, filled, stacked_rates
from amble.proof.taylor import coefficient, series


@dataclass(frozen=True, kw_only=True)
class Expansion:
    """A polynomial motion.

    Attributes:
        solution: coefficients of z, exact columns, for powers 0 ... Q.
        state: every state's coefficients of x.
        matrices: coefficients of M along it.
        defects: coefficients of R, for powers 0 ... Q.
    """

    solution: list[arb_mat]
    state: list[list[arb]]
    matrices: list[arb_mat]
    defects: list[arb_mat]

    @property
    def unknowns(self) -> list[list[arb]]:
        """Every unknown's coefficients of z."""
        return [list(row) for row in zip(*(power.entries() for power in self.solution), strict=True)]


@dataclass(frozen=True, kw_only=True)
class Variation:
    """A polynomial variation.

    Attributes:
        solution: coefficients of Z, exact, for powers 0 ... Q_V.
        slope: coefficients of V, two more: the last of positions alone.
        defects: coefficients of G, for powers 0 ... Q_V.
    """

    solution: list[arb_mat]
    slope: list[arb_mat]
    defects: list[arb_mat]


def expand(loop: LoopTapes, clock: arb, centre: Sequence[arb], order: int) -> Expansion:
    """Expand the motion from a point: every coefficient of z makes R vanish up to rounding."""
    half = loop.size // 2
    state = [[q, v] for q, v in zip(centre[:half], centre[half:], strict=True)] + [[v] for v in centre[half:]]
    solution, matrices, defects = list[arb_mat](), list[arb_mat](), list[arb_mat]()
    inverse = None
    for power in range(order + 1):
        matrix, right = _equations(loop, clock, state, power)
        matrices.append(matrix)
        for j in range(1, power + 1):
            right = right - matrices[j] * solution[power - j]
        inverse = matrices[0].inv().mid() if inverse is None else inverse
        solution.append((inverse * right).mid())
        defects.append(matrices[0] * solution[power] - right)
        for i, rate in enumerate(solution[power].entries()[:half]):
            speed = rate / (power + 1)
            state[half + i].append(speed)
            state[i].append(speed / (power + 2))
    return Expansion(solution=solution, state=state, matrices=matrices, defects=defects)


def _equations(loop: LoopTapes, clock: arb, state: Sequence[Sequence[arb]], power: int) -> tuple[arb_mat, arb_mat]:
    """Return one coefficient of M and b along a motion that is known up to it."""
    count = power + 1
    along = [series(part, count) for part in state]
    matrix, right = loop.equations([series([clock, arb(1)], count)], along, loop.parameters)
    return loop.of_matrix(matrix, power), arb_mat(loop.unknowns, 1, [coefficient(value, power) for value in right])


def vary(loop: LoopTapes, clock: arb, motion: Expansion, order: int) -> Variation:
    """Expand the first variation along a polynomial motion in the same way."""
    half, count = loop.size // 2, order + 1
    matrices, slopes = _slopes(loop, clock, motion.state, motion.unknowns, count)
    slope = [identity(loop.size)]
    inverse = matrices[0].inv().mid()
    solution, defects = list[arb_mat](), list[arb_mat]()
    for power in range(count):
        right = -(slopes[0] * slope[power])
        for j in range(1, power + 1):
            right = right - slopes[j] * slope[power - j] - matrices[j] * solution[power - j]
        solution.append((inverse * right).mid())
        defects.append(matrices[0] * solution[power] - right)
        rates = arb_mat(slope[power].tolist()[half:])
        slope.append(stacked_rates(rates, solution[power], half) / arb(power + 1))
    # one power more of the positions, so that their rates are V_v to its last power
    rates = arb_mat(slope[count].tolist()[half:])
    slope.append(stacked_rates(rates, solution[order] * 0, half) / arb(count + 1))
    return Variation(solution=solution, slope=slope, defects=defects)


def _slopes(
    loop: LoopTapes, clock: arb, state: Sequence[Sequence[arb]], unknowns: Sequence[Sequence[arb]], count: int
) -> tuple[list[arb_mat], list[arb_mat]]:
    """Return the coefficients of M and H along polynomials."""
    matrix, slope = loop.slopes(
        [series([clock, arb(1)], count)],
        [series(part, count) for part in state],
        loop.parameters,
        [series(part, count) for part in unknowns],
    )
    return (
        [loop.of_matrix(matrix, power) for power in range(count)],
        [loop.of_slope(slope, power) for power in range(count)],
    )


def motion_defect(loop: LoopTapes, clock: arb, motion: Expansion, length: arb) -> list[arb]:
    """Return upper bounds of |R| over a step, one for every equation."""
    order = len(motion.solution) - 1
    span, count = between(arb(0), length), order + 2
    state = [shifted(part, span, count) for part in motion.state]
    unknowns = [shifted(part, span, count) for part in motion.unknowns]
    along = [series(part, count) for part in state]
    matrix, right = loop.equations([series([clock + span, arb(1)], count)], along, loop.parameters)
    last = [-coefficient(value, order + 1) for value in right]
    columns = [[part[k] if k < len(part) else arb(0) for part in unknowns] for k in range(count)]
    for (row, column), entry in zip(loop.matrix_places, matrix, strict=True):
        for j in range(count):
            last[row] = last[row] + coefficient(entry, j) * columns[order + 1 - j][column]
    bounds = [value.abs_upper() * length ** (order + 1) for value in last]
    for power, defect in enumerate(motion.defects):
        bounds = [
            known + value.abs_upper() * length**power for known, value in zip(bounds, defect.entries(), strict=True)
        ]
    return [value.upper() for value in bounds]


def variation_defect(loop: LoopTapes, clock: arb, motion: Expansion, variation: Variation, length: arb) -> arb_mat:
    """Return upper bounds of |G| over a step."""
    order = len(variation.solution) - 1
    span, count = between(arb(0), length), order + 2
    state = [shifted(part, span, count) for part in motion.state]
    unknowns = [shifted(part, span, count) for part in motion.unknowns]
    matrices, slopes = _slopes(loop, clock + span, state, unknowns, count)
    solution = shifted_matrices(variation.solution, span)
    slope = shifted_matrices(variation.slope, span)
    last = slopes[0] * slope[order + 1]
    for j in range(1, count):
        last = last + matrices[j] * solution[order + 1 - j] + slopes[j] * slope[order + 1 - j]
    bound = sizes(last) * length ** (order + 1)
    for power, defect in enumerate(variation.defects):
        bound = bound + sizes(defect) * length**power
    return bound


def shifted(coefficients: Sequence[arb], start: arb, count: int) -> list[arb]:
    """Return the coefficients of a polynomial about every start in a ball, as many as are asked for."""
    moved = arb_poly(list(coefficients))(arb_poly([start, 1]))
    return [moved[k] for k in range(min(count, len(coefficients)))]


def shifted_matrices(coefficients: Sequence[arb_mat], start: arb) -> list[arb_mat]:
    """Return the same for a polynomial of matrices, all coefficients."""
    powers = [start**k for k in range(len(coefficients))]
    found = []
    for low in range(len(coefficients)):
        total = coefficients[low]
        for high in range(low + 1, len(coefficients)):
            total = total + coefficients[high] * (comb(high, low) * powers[high - low])
        found.append(total)
    return found


def sizes(matrix: arb_mat) -> arb_mat:
    """Return upper bounds of the sizes of all entries, exact."""
    return arb_mat(matrix.nrows(), matrix.ncols(), [value.abs_upper() for value in matrix.entries()])


def placed_sizes(rows: int, columns: int, places: Sequence[tuple[int, int]], values: Sequence[arb]) -> arb_mat:
    """Return the same for a matrix of which the nonzeros are given."""
    return filled(rows, columns, tuple(places), [value.abs_upper() for value in values])
