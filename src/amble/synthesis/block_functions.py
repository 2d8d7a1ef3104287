"""The compiled functions of a block: its value, gradient, Jacobian and Hessian, with the places of their nonzeros."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import casadi as ca
import numpy as np

from amble.codegen import Recipe, compile_recipes
from amble.synthesis.block import Block, Index


@dataclass(frozen=True, kw_only=True)
class BlockFunctions:
    """Compiled functions of a block and the places (rows, columns) of its derivatives' nonzeros."""

    value: ca.Function
    gradient: ca.Function
    jacobian: ca.Function
    hessian: ca.Function
    jacobian_places: tuple[Index, Index]
    hessian_places: tuple[Index, Index]


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
        value_function(block),
        ca.Function(f"{block.name}_gradient", [w, c, p], [ca.densify(ca.gradient(block.cost, w))]),
        ca.Function(f"{block.name}_jacobian", [w, c, p], [_nonzeros(jacobian)]),
        ca.Function(f"{block.name}_hessian", [w, c, p, multipliers, weight], [_nonzeros(hessian)]),
        ca.Function(f"{block.name}_places", [], [ca.SX(part) for part in places]),
    ]


def value_function(block: Block) -> ca.Function:
    """Return (w, c, p) -> (rows, cost), from which the block's other functions follow."""
    arguments = [block.variables, block.constants, block.parameters]
    return ca.Function(f"{block.name}_value", arguments, [ca.densify(block.rows), ca.densify(block.cost)])


def _nonzeros(matrix: ca.SX) -> ca.SX:
    return ca.vertcat(*matrix.nonzeros()) if matrix.nnz() else ca.SX(0, 1)


def compile_blocks(
    blocks: Sequence[Block], seeds: Mapping[str, ca.Function], iterations: float
) -> dict[str, BlockFunctions]:
    """Compile the functions of blocks where that pays.

    Args:
        blocks: the blocks.
        seeds: the ``value_function`` of each, by its name.
        iterations: about how often all instances will be evaluated.

    Returns:
        Name of the block -> its functions.
    """
    kinds = ("value", "gradient", "jacobian", "hessian", "places")
    recipes = {
        block.name: Recipe(
            (seeds[block.name],), RULE, tuple(f"{block.name}_{kind}" for kind in kinds), partial(_derive, block)
        )
        for block in blocks
    }
    pieces, evaluations = {}, {block.name: iterations * block.instances for block in blocks}
    for name, native in compile_recipes(recipes, evaluations).items():
        *functions, places = (native[f"{name}_{kind}"] for kind in kinds)
        where = [np.asarray(part).ravel().astype(np.int64) for part in places.call([])]
        value, gradient, jacobian, hessian = functions
        pieces[name] = BlockFunctions(
            value=value,
            gradient=gradient,
            jacobian=jacobian,
            hessian=hessian,
            jacobian_places=(where[0], where[1]),
            hessian_places=(where[2], where[3]),
        )
    return pieces
