"""The rank of the equality rows, checked before a solver starts: dependent rows ruin interior-point methods."""

from __future__ import annotations

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.errors import NotSolvedError, Row
from amble.synthesis.program import GaitProgram

SMALLEST = 1e-7
"""Smallest singular value of the scaled equality Jacobian, its rows normalised, below which rows count as dependent."""

SHIFT = 1e-12
"""Regularisation of the normal equations, far below SMALLEST squared."""


def smallest_singular_value(program: GaitProgram, variables: NDArray[np.float64]) -> tuple[float, NDArray[np.float64]]:
    """Return the smallest singular value of the normalised equality Jacobian and its left singular vector.

    By inverse iteration on J J^T with a sparse factor; at most a second where a dense decomposition takes minutes.

    Args:
        program: the transcribed problem.
        variables: scaled variables at which to look, (n_x,).
    """
    from scipy.sparse import csc_matrix, diags, identity
    from scipy.sparse.linalg import splu

    nlp = program.program
    jacobian: ca.DM = nlp.jacobian(variables, program.parameters)[1]
    rows, columns = jacobian.sparsity().get_triplet()
    whole = csc_matrix((jacobian.nonzeros(), (rows, columns)), shape=jacobian.shape).tocsr()
    free = program.lower < program.upper
    equal = whole[nlp.lower == nlp.upper][:, free]
    lengths = np.sqrt(np.asarray(equal.multiply(equal).sum(axis=1)).ravel())
    normal = diags(1.0 / np.maximum(lengths, 1e-300)) @ equal
    gram = (normal @ normal.T + SHIFT * identity(normal.shape[0])).tocsc()
    factor = splu(gram, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}, diag_pivot_thresh=0.0)
    vector = np.random.default_rng(0).normal(size=normal.shape[0])
    for _ in range(8):
        vector = factor.solve(vector)
        vector /= np.linalg.norm(vector)
    return float(np.linalg.norm(normal.T @ vector)), vector


def require_full_rank(program: GaitProgram, variables: NDArray[np.float64]) -> float:
    """Return the smallest singular value; raise where equality rows depend on each other.

    The point is moved off the given variables by a small fixed random step: a standing robot is a special pose at
    which rows may be dependent that are not so anywhere near.

    Raises:
        NotSolvedError: names the rows that depend on each other.
    """
    step = np.random.default_rng(1).uniform(-0.05, 0.05, variables.size)
    value, vector = smallest_singular_value(program, variables + step)
    if value >= SMALLEST:
        return value
    nlp = program.program
    names = np.array(nlp.row_names)[nlp.lower == nlp.upper]
    worst = np.argsort(-np.abs(vector))[:8]
    rows = [Row(f"{names[i]} (weight {vector[i]:.2f})", 0.0, 0.0, 0.0) for i in worst]
    raise NotSolvedError(f"equality rows depend on each other (smallest singular value {value:.1e})", rows)
