"""A sparse nonlinear program assembled from small compiled blocks: each function is repeated over index sets.

Every derivative is exact and every nonzero has a fixed place, so that an iteration of the solver only calls the
blocks' compiled code and scatters their numbers.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from hashlib import sha256
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.codegen import compiler
from amble.codegen.cache import content_key, function_key
from amble.synthesis.block import Block, Index
from amble.synthesis.block_functions import BlockFunctions, compile_blocks, value_function


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
    units = np.array([label.unit for b in blocks for _ in b.places for label in b.labels])
    known = {unit: row_size(unit) for unit in set(units.tolist())}
    row_scale = np.array([known[unit] for unit in units.tolist()])
    sizes = _Sizes(scale=scale, row_scale=row_scale, cost_scale=cost_scale, parameter_count=parameter_count)
    seeds = {block.name: value_function(block) for block in blocks}
    recipe = _Recipe(_key(blocks, seeds, sizes), iterations, tuple(blocks), seeds, sizes)
    functions = _functions(recipe)
    return Program(
        nlp=functions.nlp,
        gradient=functions.gradient,
        jacobian=functions.jacobian,
        hessian=functions.hessian,
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


@dataclass(frozen=True, kw_only=True)
class _Sizes:
    """Scales of variables, rows and cost, and the number of parameters."""

    scale: NDArray[np.float64]
    row_scale: NDArray[np.float64]
    cost_scale: float
    parameter_count: int


@dataclass(frozen=True)
class _Recipe:
    """What the functions of a program are made from; recipes with the same key and as many iterations are equal."""

    key: str
    iterations: float
    blocks: tuple[Block, ...] = field(compare=False)
    seeds: dict[str, ca.Function] = field(compare=False)
    sizes: _Sizes = field(compare=False)


@dataclass(frozen=True, kw_only=True)
class _Functions:
    """The four functions of a program."""

    nlp: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function


def _key(blocks: Sequence[Block], seeds: dict[str, ca.Function], sizes: _Sizes) -> str:
    """Content hash of everything that the functions follow from; bounds and names are no part of it."""
    arrays = [sizes.scale, sizes.row_scale, np.array([sizes.cost_scale, sizes.parameter_count])]
    arrays += [array for block in blocks for array in (block.columns, block.values)]
    texts = [f"{array.shape} {sha256(array.tobytes()).hexdigest()}" for array in arrays]
    return content_key([repr(compiler()), *texts, *map(function_key, seeds.values())])


@lru_cache(maxsize=16)
def _functions(recipe: _Recipe) -> _Functions:
    """Build the functions of a program, once for all programs that differ in bounds and parameters alone."""
    blocks, sizes = recipe.blocks, recipe.sizes
    scale, row_scale, cost_scale = sizes.scale, sizes.row_scale, sizes.cost_scale
    x, p = ca.MX.sym("x", scale.size), ca.MX.sym("p", sizes.parameter_count)
    natural = x * ca.DM(scale)
    compiled = compile_blocks(blocks, recipe.seeds, recipe.iterations)
    rows, costs = [], []
    for block in blocks:
        value = _mapped(compiled[block.name].value, block, natural, p)
        rows.append(ca.vec(value[0]))
        costs.append(ca.sum2(value[1]))
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
    return _Functions(
        nlp=ca.Function("nlp", [x, p], [f, g], ["x", "p"], ["f", "g"]),
        gradient=ca.Function("nlp_grad_f", [x, p], [f, gradient], ["x", "p"], ["f", "grad_f_x"]),
        jacobian=ca.Function("nlp_jac_g", [x, p], [g, jacobian], ["x", "p"], ["g", "jac_g_x"]),
        hessian=ca.Function(
            "nlp_hess_l", [x, p, lam_f, lam_g], [hessian], ["x", "p", "lam_f", "lam_g"], ["hess_gamma_x_x"]
        ),
    )


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


def _jacobian_places(blocks: Sequence[Block], pieces: dict[str, BlockFunctions]) -> tuple[Index, Index]:
    rows, columns, offset = [], [], 0
    for block in blocks:
        local_row, local_column = pieces[block.name].jacobian_places
        start = offset + np.arange(block.instances)[:, None] * block.rows.shape[0]
        rows.append((start + local_row).ravel())
        columns.append(block.columns[:, local_column].ravel())
        offset += block.instances * block.rows.shape[0]
    return np.concatenate(rows), np.concatenate(columns)


def _hessian_places(blocks: Sequence[Block], pieces: dict[str, BlockFunctions]) -> tuple[Index, Index]:
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
