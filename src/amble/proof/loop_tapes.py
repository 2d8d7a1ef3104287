"""A closed loop whose accelerations solve linear equations, as tapes.

With x = (q, v) it is

    q' = v,    v' = S z,    M(t, x) z = b(t, x),    H(t, x, z) = d/dx (M z - b) at fixed z.                      (1)

Nothing is eliminated: M, b and H are evaluated, and the equations are solved as they stand (docs/theory/proof.md,
section 6). S picks the first n_q unknowns.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import casadi as ca
from flint import arb, arb_mat

from amble.control.loop_equations import LoopEquations
from amble.proof.tape import Tape, Value, record
from amble.proof.taylor import coefficient
from amble.types import Vector

Places = tuple[tuple[int, int], ...]
"""(row, column) of the nonzeros of a matrix."""


@dataclass(frozen=True, kw_only=True)
class LoopTapes:
    """The equations of (1) as tapes.

    Attributes:
        equations: tape of the nonzeros of M, and b, over (t, x, p).
        slopes: tape of the nonzeros of M and H, over (t, x, p, z).
        matrix_places: of the nonzeros of M.
        slope_places: of the nonzeros of H.
        parameters: the value of p.
        size: number of states.
        unknowns: number of unknowns.
    """

    equations: Tape
    slopes: Tape
    matrix_places: Places
    slope_places: Places
    parameters: tuple[arb, ...]
    size: int
    unknowns: int

    @classmethod
    def of(cls, loop: LoopEquations, symbols: Sequence[ca.SX], values: Vector) -> LoopTapes:
        """Take the equations of a loop.

        Args:
            loop: the equations.
            symbols: t, x, p.
            values: of p.

        Raises:
            InputError: they hold an operation that has no enclosure.
        """
        t, x, p = symbols
        z = ca.SX.sym("z", loop.right.shape[0])
        matrix = loop.matrix
        slope = ca.jacobian(matrix @ z - loop.right, x)
        names = ["t", "x", "p", "z"]
        equations = ca.Function("equations", [t, x, p], ca.cse([matrix, ca.densify(loop.right)]), names[:3], ["M", "b"])
        slopes = ca.Function("slopes", [t, x, p, z], ca.cse([matrix, slope]), names, ["M", "H"])
        return cls(
            equations=record(equations),
            slopes=record(slopes),
            matrix_places=_places(matrix),
            slope_places=_places(slope),
            parameters=tuple(arb(float(value)) for value in values),
            size=x.shape[0],
            unknowns=z.shape[0],
        )

    def at(self, values: Vector) -> LoopTapes:
        """Return the same for other values of p."""
        return replace(self, parameters=tuple(arb(float(value)) for value in values))

    def of_matrix(self, values: Sequence[Value], power: int = 0) -> arb_mat:
        """Fill a coefficient of M from its nonzeros."""
        return filled(self.unknowns, self.unknowns, self.matrix_places, values, power)

    def of_slope(self, values: Sequence[Value], power: int = 0) -> arb_mat:
        """Fill a coefficient of H from its nonzeros."""
        return filled(self.unknowns, self.size, self.slope_places, values, power)


def filled(rows: int, columns: int, places: Places, values: Sequence[Value], power: int = 0) -> arb_mat:
    """Return a matrix of which one coefficient of every nonzero is given."""
    entries = [arb(0)] * (rows * columns)
    for (row, column), value in zip(places, values, strict=True):
        entries[row * columns + column] = coefficient(value, power)
    return arb_mat(rows, columns, entries)


def stacked_rates(below: arb_mat, solution: arb_mat, half: int) -> arb_mat:
    """Return the rows q' from v, of ``below``, over the first rows of a solution."""
    return arb_mat([*below.tolist(), *solution.tolist()[:half]])


def _places(matrix: ca.SX) -> Places:
    rows, columns = matrix.sparsity().get_triplet()
    return tuple(zip(rows, columns, strict=True))
