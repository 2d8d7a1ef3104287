"""Fundamental solutions of Phi' = F(t) Phi, F = [0 1; L D], by Gauss collocation, and their slopes in F.

Unknowns are the accelerations at the stages (``collocation.c``, eq. 1), so that the slope takes the transpose of the
same factors. Where there is no compiler numpy solves the same equations.
"""

from __future__ import annotations

import ctypes
import functools
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import legendre
from numpy.typing import NDArray

from amble.codegen.c_file import numerical
from amble.numerics.blas import addresses
from amble.types import Matrix, NodeValues, Vector

ROUTINES = {"cython_blas": ("dgemm",), "cython_lapack": ("dgetrf", "dgetrs")}
"""What the C code calls, in its order."""

DOUBLES, INTEGERS = ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_int)


@dataclass(frozen=True, eq=False)
class GaussRule:
    """Gauss-Legendre collocation on [0, 1]: nodes c (s,), quadrature weights b (s,), Butcher matrix A (s, s)."""

    nodes: Vector
    weights: Vector
    integration: Matrix

    @classmethod
    def of(cls, stages: int) -> GaussRule:
        """Build the rule with s nodes, of order 2 s."""
        roots, halves = legendre.leggauss(stages)
        nodes = 0.5 * (roots + 1.0)
        powers = np.arange(1, stages + 1)
        integration = (nodes[:, None] ** powers / powers) @ np.linalg.inv(nodes[:, None] ** (powers - 1))
        return cls(nodes, 0.5 * halves, integration)

    @functools.cached_property
    def twice(self) -> Matrix:
        """A A, which takes accelerations to positions."""
        return np.asarray(self.integration @ self.integration)

    @functools.cached_property
    def last(self) -> Vector:
        """B A: the same at the end."""
        return np.asarray(self.weights @ self.integration)


class _Rule(ctypes.Structure):
    """``Rule`` of collocation.c."""

    _fields_ = [
        *((name, ctypes.c_void_p) for names in ROUTINES.values() for name in names),
        *((name, DOUBLES) for name in ("rule", "twice", "nodes", "weights", "last")),
        ("stages", ctypes.c_int),
    ]


@dataclass(frozen=True, kw_only=True)
class Fundamental:
    """A fundamental solution in panels.

    Attributes:
        rule: of the collocation.
        step: length of a panel, s.
        whole: Phi(T, 0), (n, n).
        until: Phi(t_k, 0) at all nodes, (k, n, n).
        factors: of every panel, LU factors with ``pivots``; without these the matrix itself, (panels, m, m).
        pivots: (panels, m); None where numpy solves.
        rights: right sides of the panels, (panels, m, n).
    """

    rule: GaussRule
    step: float
    whole: Matrix
    until: NodeValues
    factors: NodeValues
    pivots: NDArray[np.int32] | None
    rights: NodeValues

    def pulled(self, rows: Matrix) -> NodeValues:
        """Return W_k with which rows times Phi(T, 0) change by sum_k W_k dF_k Phi(t_k, 0), (k, q, n / 2).

        Args:
            rows: P, (q, n); dF_k are changes of the lower rows [L D] of F at the nodes, (n / 2, n).
        """
        native = None if self.pivots is None else _native(self.rule)
        if native is None or self.pivots is None:
            return self._pulled(rows)
        library, rule = native
        (panels, size, _), (count, n) = self.factors.shape, rows.shape
        carried, work = np.array(rows, dtype=np.float64, order="C"), np.empty(size * count)
        found = np.empty((len(self.until), count, n // 2))
        library.amble_pulled(
            ctypes.byref(rule), n, panels, self.step, count, _doubles(carried), _doubles(self.factors),
            self.pivots.ctypes.data_as(INTEGERS), _doubles(self.rights), _doubles(found), _doubles(work),
        )  # fmt: skip
        return found

    def _pulled(self, rows: Matrix) -> NodeValues:
        rule, (count, n), stages = self.rule, rows.shape, self.rule.weights.size
        carried, half = np.array(rows), n // 2
        found = np.empty((len(self.factors), count, stages * half))
        for panel in reversed(range(len(self.factors))):
            x, v = carried[:, :half], carried[:, half:]
            right = self.step * np.kron(rule.weights, v) + self.step**2 * np.kron(rule.last, x)
            found[panel] = np.linalg.solve(self.factors[panel].T, right.T).T
            carried = np.hstack([x, v + self.step * x]) + found[panel] @ self.rights[panel]
        return found.reshape(-1, count, stages, half).transpose(0, 2, 1, 3).reshape(-1, count, half)


def fundamental(rule: GaussRule, duration: float, fields: NodeValues) -> Fundamental:
    """Solve Phi' = F(t) Phi, Phi(0) = 1, in panels of equal length.

    Args:
        rule: of the collocation.
        duration: s.
        fields: F at the nodes of all panels, whose upper rows are [0 1], (k, n, n).

    Raises:
        numpy.linalg.LinAlgError: the equations of a panel are singular.
    """
    stages, (count, n, _) = rule.weights.size, fields.shape
    panels = count // stages
    step, native = duration / panels, _native(rule)
    if native is None:
        return _fundamental(rule, step, fields.reshape(panels, stages, n, n))
    library, structure = native
    size = stages * n // 2
    columns = np.ascontiguousarray(fields.transpose(0, 2, 1))  # as the functions write them
    until, whole, work = np.empty_like(columns), np.empty((n, n)), np.empty(size * n)
    factors, pivots, rights = (
        np.empty((panels, size, size)),
        np.empty((panels, size), np.int32),
        np.empty((panels, n, size)),
    )
    failed = library.amble_transported(
        ctypes.byref(structure), n, panels, step, _doubles(columns), _doubles(until), _doubles(whole),
        _doubles(factors), pivots.ctypes.data_as(INTEGERS), _doubles(rights), _doubles(work),
    )  # fmt: skip
    if failed:
        raise np.linalg.LinAlgError(f"the equations of panel {failed - 1} are singular")
    return Fundamental(
        rule=rule,
        step=step,
        whole=whole.T,
        until=until.transpose(0, 2, 1),
        factors=factors,
        pivots=pivots,
        rights=rights,
    )


def _fundamental(rule: GaussRule, step: float, fields: NodeValues) -> Fundamental:
    """Do the same with numpy."""
    panels, stages, n, _ = fields.shape
    half, size = n // 2, stages * n // 2
    stiffness, damping = fields[:, :, half:, :half], fields[:, :, half:, half:]
    blocks = step * np.einsum("ij,pirc->pirjc", rule.integration, damping)
    blocks += step**2 * np.einsum("ij,pirc->pirjc", rule.twice, stiffness)
    system = np.eye(size) - blocks.reshape(panels, size, size)
    rights = np.concatenate([stiffness, step * rule.nodes[:, None, None] * stiffness + damping], axis=3)
    rights = rights.reshape(panels, size, n)
    across, whole, until = np.linalg.solve(system, rights), np.eye(n), np.empty_like(fields)
    for panel in range(panels):
        rates = (across[panel] @ whole).reshape(stages, half, n)
        x, v = whole[:half], whole[half:]
        until[panel, :, :half] = x + np.multiply.outer(step * rule.nodes, v)
        until[panel, :, :half] += step**2 * np.tensordot(rule.twice, rates, 1)
        until[panel, :, half:] = v + step * np.tensordot(rule.integration, rates, 1)
        whole = np.vstack(
            [
                x + step * v + step**2 * np.tensordot(rule.last, rates, 1),
                v + step * np.tensordot(rule.weights, rates, 1),
            ]
        )
    return Fundamental(
        rule=rule,
        step=step,
        whole=whole,
        until=until.reshape(-1, n, n),
        factors=system,
        pivots=None,
        rights=rights,
    )


@functools.cache
def _native(rule: GaussRule) -> tuple[ctypes.CDLL, _Rule] | None:
    """Return the library and the rule for it; None where there is none."""
    library = numerical(Path(__file__).with_suffix(".c"))
    if library is None:
        return None
    library.amble_transported.argtypes = [
        ctypes.POINTER(_Rule), ctypes.c_int, ctypes.c_int, ctypes.c_double, DOUBLES, DOUBLES, DOUBLES, DOUBLES,
        INTEGERS, DOUBLES, DOUBLES,
    ]  # fmt: skip
    library.amble_pulled.argtypes = [
        ctypes.POINTER(_Rule), ctypes.c_int, ctypes.c_int, ctypes.c_double, ctypes.c_int, DOUBLES, DOUBLES, INTEGERS,
        DOUBLES, DOUBLES, DOUBLES,
    ]  # fmt: skip
    library.amble_pulled.restype = None
    arrays = (rule.integration, rule.twice, rule.nodes, rule.weights, rule.last)  # the rule, in this cache, keeps them
    return library, _Rule(*addresses(ROUTINES), *map(_doubles, arrays), rule.weights.size)


def _doubles(array: NodeValues) -> Any:
    """Pointer to the memory of an array, which it keeps alive."""
    return array.ctypes.data_as(DOUBLES)
