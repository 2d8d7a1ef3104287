"""KKT systems of gait programs as IPOPT hands them to MA27, for tests of the structured solver."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass

import numpy as np

from amble.synthesis.program import GaitProgram
from amble.synthesis.structured_kkt import StructuredKkt

SINGULAR = -5
"""MA27's flag of a singular matrix."""


@dataclass(frozen=True)
class KktSystem:
    """A symmetric matrix by triplets, 1-based, its lower or upper triangle; in IPOPT's order x, s, y_c, y_d.

    Attributes:
        size: of the matrix.
        rows: 1-based.
        columns: 1-based.
        values: of the triplets; repeated ones add up.
        primal: how many of the unknowns are variables and slacks.
    """

    size: int
    rows: np.ndarray
    columns: np.ndarray
    values: np.ndarray
    primal: int

    def dense(self) -> np.ndarray:
        """The whole matrix."""
        whole = np.zeros((self.size, self.size))
        np.add.at(whole, (self.rows - 1, self.columns - 1), self.values)
        return np.tril(whole) + np.triu(whole, 1).T + np.tril(np.tril(whole, -1) + np.triu(whole, 1).T, -1).T


def kkt_system(
    program: GaitProgram,
    variables: np.ndarray,
    rng: np.random.Generator,
    *,
    barrier: float = 0.1,
    shift: float = 0.0,
    regularised: float = 0.0,
    curvature: float = 1.0,
    active: int = 0,
) -> KktSystem:
    """Return the system of a barrier problem with random multipliers.

    Args:
        program: the program.
        variables: scaled variables, (n_x,).
        rng: draws multipliers and distances from bounds.
        barrier: the entries of Sigma lie between this and its inverse, evenly in the logarithm.
        shift: added to the diagonal of variables and slacks.
        regularised: subtracted from the diagonal of the rows.
        curvature: factor of the Hessian.
        active: how many entries each of Sigma of variables and of slacks are 1e16, as those of active bounds are at the
            end of a solve; few, since many are seldom independent.
    """
    nlp, parameters = program.program, program.parameters
    equal = nlp.equalities
    fixed = np.flatnonzero(program.lower == program.upper)
    _, slopes = nlp.linearised(variables, parameters)
    multipliers = rng.normal(size=equal.size)
    hessian = nlp.hessian(variables, parameters, 1.0, multipliers)
    n, m, extra = variables.size, int(equal.sum()) + fixed.size, int((~equal).sum())
    s, c, d = n, n + extra, n + extra + m
    place = np.where(equal, c + np.cumsum(equal) - 1, d + np.cumsum(~equal) - 1)
    h_rows, h_columns = (np.array(x) for x in hessian.sparsity().get_triplet())
    jacobian = slopes.tocoo()
    free = np.isfinite(program.lower) | np.isfinite(program.upper)
    free[fixed] = False
    bounded = np.isfinite(nlp.lower[~equal]) | np.isfinite(nlp.upper[~equal])

    def sigma(where: np.ndarray) -> np.ndarray:
        drawn = barrier ** rng.uniform(-1.0, 1.0, where.size)
        drawn[rng.choice(np.flatnonzero(where), active, replace=False)] = 1e16
        return np.where(where, drawn, 0.0) + shift

    parts = [
        (h_rows, h_columns, curvature * np.array(hessian.nonzeros())),
        (np.arange(n), np.arange(n), sigma(free)),
        (s + np.arange(extra), s + np.arange(extra), sigma(bounded)),
        (place[jacobian.row], jacobian.col, jacobian.data),
        (d - fixed.size + np.arange(fixed.size), fixed, np.ones(fixed.size)),
        (d + np.arange(extra), s + np.arange(extra), -np.ones(extra)),
        (c + np.arange(m + extra), c + np.arange(m + extra), np.full(m + extra, -regularised)),
    ]
    rows, columns, values = (np.concatenate(part) for part in zip(*parts, strict=True))
    return KktSystem(d + extra, (rows + 1).astype(np.int32), (columns + 1).astype(np.int32), values, n + extra)


class Ma27:
    """The functions that IPOPT calls, on one system; the numbers that are no use here are left out."""

    def __init__(self, solver: StructuredKkt, system: KktSystem) -> None:
        self.solver, self.system, self.analysed = solver, system, system  # whose places are pointed to
        self.keep, self.work = np.zeros(3 * system.size, np.int32), np.zeros(8, np.int32)
        self.info, self.one = np.zeros(20, np.int32), ctypes.byref(ctypes.c_int(1))
        numbers = [ctypes.byref(ctypes.c_int(n)) for n in (system.size, system.values.size)]
        self.places = [*numbers, _at(system.rows), _at(system.columns)]
        self.solver.library.ma27ad_(
            *self.places, _at(self.work), self.one, _at(self.keep), None, self.one, self.one, None, None,
            _at(self.info), ctypes.byref(ctypes.c_double()),
        )  # fmt: skip
        self.flag = int(self.info[0])

    def factor(self) -> tuple[int, int]:
        """Return MA27's flag and the number of negative eigenvalues."""
        self.solver.library.ma27bd_(
            *self.places, _at(self.system.values), self.one, _at(self.work), self.one, _at(self.keep), self.one,
            self.one, None, None, None, _at(self.info),
        )  # fmt: skip
        return int(self.info[0]), int(self.info[14])

    def solve(self, right: np.ndarray) -> np.ndarray:
        """Return the solution."""
        found = right.copy()
        self.solver.library.ma27cd_(
            self.places[0], _at(self.system.values), self.one, _at(self.work), self.one, None, self.one, _at(found),
            None, self.one, None, None,
        )  # fmt: skip
        return found


def _at(array: np.ndarray) -> ctypes.c_void_p:
    return ctypes.c_void_p(array.ctypes.data)
