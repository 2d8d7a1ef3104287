"""A sparse nonlinear program assembled from small compiled blocks: each function is repeated over index sets.

Every derivative is exact and every nonzero has a fixed place, so that an iteration of the solver only calls the
blocks' compiled code and scatters their numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.codegen import Recipe, compile_recipes
from amble.synthesis.block import Block, Index


@dataclass(frozen=True, kw_only=True)
class Program:
    """The functions of a nonlinear program in scaled variables, rows and cost; parameters keep their units.

    Attributes:
        nlp: (x, p) -> (f, g).
        gradient: (x, p) -> (f, df/dx).
        jacobian: (x, p) -> (g, dg/dx).
        hessian: (x, p, lam_f, lam_g) -> upper triangle of the Hessian of the Lagrangian.
        row_names: name of every row of g.
        row_kinds: kind of every row of g, an array of text.
        row_instances: which instance of its block every row of g belongs to, such as the node of a domain.
        row_units: unit of every row before it was scaled, an array of text.
        row_scale: size of one unit of every scaled row, (n_g,).
        cost_scale: the same of f.
        lower: lower bounds of g.
        upper: upper bounds of g.
    """

    nlp: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    row_names: tuple[str, ...]
    row_kinds: NDArray[np.str_]
    row_instances: Index
    row_units: NDArray[np.str_]
    row_scale: NDArray[np.float64]
    cost_scale: float
    lower: NDArray[np.float64]
    upper: NDArray[np.float64]

    @property
    def equalities(self) -> NDArray[np.bool_]:
        """Which rows of g are equations."""
        return self.lower == self.upper

    def linearised(self, x: NDArray[np.float64], p: NDArray[np.float64]) -> tuple[NDArray[np.float64], Any]:
        """Return g and dg/dx at a point, the slopes as a sparse matrix of scipy (csr).

        Args:
            x: scaled variables, (n_x,).
            p: parameters, (n_p,).
        """
        from scipy.sparse import csc_matrix

        g, slopes = self.jacobian(x, p)
        rows, columns = slopes.sparsity().get_triplet()
        return np.asarray(g).ravel(), csc_matrix((slopes.nonzeros(), (rows, columns)), shape=slopes.shape).tocsr()

    def excess(self, values: NDArray[np.float64]) -> NDArray[np.float64]:
        """How far each row of g lies outside its bounds; zero inside."""
        return np.maximum(np.maximum(self.lower - values, values - self.upper), 0.0)


@dataclass(frozen=True, kw_only=True)
class _Pieces:
    """Compiled functions of a block and the places (rows, columns) of its derivatives' nonzeros."""

    value: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    jacobian_places: tuple[Index, Index]
    hessian_places: tuple[Index, Index]


def assemble(
    blocks: Sequence[Block],
    scale: NDArray[np.float64],
    parameter_count: int,
    row_size: Callable[[str], float],
    cost_scale: float,
    iterations: float,
) -> Program:
    """Assemble blocks into one program.

    Args:
        blocks: the blocks; their rows follow each other in this order, instance by instance.
        scale: size of one unit of every scaled variable, (n_x,).
        parameter_count: number of parameters n_p.
        row_size: unit of a label -> size of one unit of the scaled row.
        cost_scale: size of one unit of the scaled objective.
        iterations: about how often all will be evaluated: whether compiling a block pays.
    """
    x, p = ca.MX.sym("x", scale.size), ca.MX.sym("p", parameter_count)
    natural = x * ca.DM(scale)
    compiled = _compile(blocks, iterations)
    rows, costs = [], []
    for block in blocks:
        value = _mapped(compiled[block.name].value, block, natural, p)
        rows.append(ca.vec(value[0]))
        costs.append(ca.sum2(value[1]))
    units = np.array([label.unit for b in blocks for _ in b.places for label in b.labels])
    known = {unit: row_size(unit) for unit in set(units.tolist())}
    row_scale = np.array([known[unit] for unit in units.tolist()])
    g, f = ca.vertcat(*rows) / ca.DM(row_scale), sum(costs) / cost_scale
    slopes = [_mapped(compiled[b.name].gradient, b, natural, p)[0] for b in blocks]
    gradient = _scatter(ca.vertcat(*[ca.vec(s) for s in slopes]), _gradient_places(blocks), scale / cost_scale)
    entries = [_mapped(compiled[b.name].jacobian, b, natural, p)[0] for b in blocks]
    places = _jacobian_places(blocks, compiled)
    jacobian = _scatter_rows(ca.vertcat(*[ca.vec(e) for e in entries]), places, scale, row_scale)
    lam_f, lam_g = ca.MX.sym("lam_f"), ca.MX.sym("lam_g", g.shape[0])
    natural_f, natural_g = lam_f / cost_scale, lam_g / ca.DM(row_scale)
    curvature, offset = [], 0
    for block in blocks:
        count = block.instances * block.rows.shape[0]
        multipliers = ca.reshape(natural_g[offset : offset + count], block.rows.shape[0], block.instances)
        curvature.append(_mapped(compiled[block.name].hessian, block, natural, p, multipliers, natural_f)[0])
        offset += count
    hessian = _scatter_symmetric(ca.vertcat(*[ca.vec(c) for c in curvature]), _hessian_places(blocks, compiled), scale)
    return Program(
        nlp=ca.Function("nlp", [x, p], [f, g], ["x", "p"], ["f", "g"]),
        gradient=ca.Function("nlp_grad_f", [x, p], [f, gradient], ["x", "p"], ["f", "grad_f_x"]),
        jacobian=ca.Function("nlp_jac_g", [x, p], [g, jacobian], ["x", "p"], ["g", "jac_g_x"]),
        hessian=ca.Function(
            "nlp_hess_l", [x, p, lam_f, lam_g], [hessian], ["x", "p", "lam_f", "lam_g"], ["hess_gamma_x_x"]
        ),
        row_names=tuple(
            f"{place} {label.name}" for block in blocks for place in block.places for label in block.labels
        ),
        row_kinds=np.array([label.kind for b in blocks for _ in b.places for label in b.labels]),
        row_instances=np.concatenate([np.repeat(np.arange(b.instances), len(b.labels)) for b in blocks]),
        row_units=units,
        row_scale=row_scale,
        cost_scale=cost_scale,
        lower=np.concatenate([block.lower.ravel() for block in blocks]) / row_scale,
        upper=np.concatenate([block.upper.ravel() for block in blocks]) / row_scale,
    )


RULE = "block-1"
"""Changes whenever ``_derive`` would give other functions for the same block."""


def _derive(block: Block) -> list[ca.Function]:
    """Differentiate a block: value, gradient of the cost, nonzeros of the Jacobian and of the Lagrangian's Hessian."""
    w, c, p = block.variables, block.constants, block.parameters
    multipliers, weight = ca.SX.sym("lam", block.rows.shape[0]), ca.SX.sym("sigma")
    lagrangian = weight * block.cost + ca.dot(multipliers, block.rows)
    jacobian = ca.jacobian(block.rows, w)
    hessian = ca.triu(ca.hessian(lagrangian, w)[0])
    places = [ca.DM(part) for matrix in (jacobian, hessian) for part in matrix.sparsity().get_triplet()]
    return [
        _value(block),
        ca.Function(f"{block.name}_gradient", [w, c, p], [ca.densify(ca.gradient(block.cost, w))]),
        ca.Function(f"{block.name}_jacobian", [w, c, p], [_nonzeros(jacobian)]),
        ca.Function(f"{block.name}_hessian", [w, c, p, multipliers, weight], [_nonzeros(hessian)]),
        ca.Function(f"{block.name}_places", [], [ca.SX(part) for part in places]),
    ]


def _value(block: Block) -> ca.Function:
    arguments = [block.variables, block.constants, block.parameters]
    return ca.Function(f"{block.name}_value", arguments, [ca.densify(block.rows), ca.densify(block.cost)])


def _nonzeros(matrix: ca.SX) -> ca.SX:
    return ca.vertcat(*matrix.nonzeros()) if matrix.nnz() else ca.SX(0, 1)


def _compile(blocks: Sequence[Block], iterations: float) -> dict[str, _Pieces]:
    kinds = ("value", "gradient", "jacobian", "hessian", "places")
    recipes = {
        block.name: Recipe(
            (_value(block),), RULE, tuple(f"{block.name}_{kind}" for kind in kinds), partial(_derive, block)
        )
        for block in blocks
    }
    pieces, evaluations = {}, {block.name: iterations * block.instances for block in blocks}
    for name, native in compile_recipes(recipes, evaluations).items():
        *functions, places = (native[f"{name}_{kind}"] for kind in kinds)
        where = [np.asarray(part).ravel().astype(np.int64) for part in places.call([])]
        value, gradient, jacobian, hessian = functions
        pieces[name] = _Pieces(
            value=value,
            gradient=gradient,
            jacobian=jacobian,
            hessian=hessian,
            jacobian_places=(where[0], where[1]),
            hessian_places=(where[2], where[3]),
        )
    return pieces


def _mapped(function: ca.Function, block: Block, natural: ca.MX, p: ca.MX, *more: ca.MX) -> list[ca.MX]:
    """Evaluate a block's function at all instances: every result has one column an instance."""
    count = block.instances
    local = ca.reshape(natural[block.columns.ravel().tolist()], block.columns.shape[1], count)
    constants = ca.DM(block.values.T) if block.values.size else ca.DM(0, count)
    arguments = [local, constants, ca.repmat(p, 1, count)]
    arguments += [a if a.shape[1] == count else ca.repmat(a, 1, count) for a in more]
    result = function.map(count)(*arguments)
    return list(result) if isinstance(result, (tuple, list)) else [result]


def _gradient_places(blocks: Sequence[Block]) -> Index:
    return np.concatenate([block.columns.ravel() for block in blocks])


def _jacobian_places(blocks: Sequence[Block], pieces: dict[str, _Pieces]) -> tuple[Index, Index]:
    rows, columns, offset = [], [], 0
    for block in blocks:
        local_row, local_column = pieces[block.name].jacobian_places
        start = offset + np.arange(block.instances)[:, None] * block.rows.shape[0]
        rows.append((start + local_row).ravel())
        columns.append(block.columns[:, local_column].ravel())
        offset += block.instances * block.rows.shape[0]
    return np.concatenate(rows), np.concatenate(columns)


def _hessian_places(blocks: Sequence[Block], pieces: dict[str, _Pieces]) -> tuple[Index, Index]:
    first, second = [], []
    for block in blocks:
        a, b = pieces[block.name].hessian_places
        first.append(block.columns[:, a].ravel())
        second.append(block.columns[:, b].ravel())
    rows, columns = np.concatenate(first), np.concatenate(second)
    return np.minimum(rows, columns), np.maximum(rows, columns)


def _scatter(values: ca.MX, places: Index, size: NDArray[np.float64]) -> ca.MX:
    """Add values into a vector, each times the size of its place."""
    ones = ca.DM.triplet(places.tolist(), list(range(places.size)), ca.DM(size[places]), size.size, places.size)
    return ca.densify(ones @ values)


def _scatter_rows(
    values: ca.MX, places: tuple[Index, Index], scale: NDArray[np.float64], row_scale: NDArray[np.float64]
) -> ca.MX:
    """Add values into a matrix (rows, columns), in scaled variables and rows."""
    rows, columns = places
    return _sum_into(values * ca.DM(scale[columns] / row_scale[rows]), rows, columns, (row_scale.size, scale.size))


def _scatter_symmetric(values: ca.MX, places: tuple[Index, Index], scale: NDArray[np.float64]) -> ca.MX:
    rows, columns = places
    return _sum_into(values * ca.DM(scale[rows] * scale[columns]), rows, columns, (scale.size, scale.size))


def _sum_into(values: ca.MX, rows: Index, columns: Index, shape: tuple[int, int]) -> ca.MX:
    """Place values in a sparse matrix; values with the same place add up."""
    key = columns * shape[0] + rows
    unique, inverse = np.unique(key, return_inverse=True)
    pattern = ca.Sparsity.triplet(*shape, (unique % shape[0]).tolist(), (unique // shape[0]).tolist())
    if unique.size == key.size:
        order = np.argsort(inverse)
        return ca.MX(pattern, values[order.tolist()])
    total = ca.DM.triplet(inverse.tolist(), list(range(key.size)), ca.DM.ones(key.size), unique.size, key.size)
    return ca.MX(pattern, ca.densify(total @ values))
