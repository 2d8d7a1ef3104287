"""A solver of one's own: Newton's method on the active rows, for neighbours of a solved problem. One registration."""

from __future__ import annotations

import time

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import bmat, csc_matrix, eye, vstack
from scipy.sparse.linalg import splu

from amble.progress import Progress, ProgressReport
from amble.synthesis.program import GaitProgram
from amble.synthesis.solve import SOLVERS, Solution, Start, finished

Values = NDArray[np.float64]

DIVERGED = 1e6
"""Residual from which the start was not near."""

REGULAR = 1e-10
"""Weight of the change of multipliers, which keeps the equations solvable where active rows depend on each other."""


def active_set(
    program: GaitProgram,
    start: Start,
    tolerance: float,
    most_iterations: int,
    progress: Progress | None,
) -> Solution:
    """Solve the optimality conditions by a semismooth Newton method (primal-dual active set).

    With c = (x, g(x)) between its bounds and multipliers m, a row counts as active at its upper bound where
    m + c - upper is positive, at its lower one where m + c - lower is negative. The step solves the linearised
    conditions with the active rows at their bounds and the other multipliers zero. There is no line search: it
    converges fast from a neighbour's solution with its multipliers, and says so where it does not.
    """
    nlp, size, began = program.program, program.lower.size, time.perf_counter()
    lower, upper = np.concatenate([program.lower, nlp.lower]), np.concatenate([program.upper, nlp.upper])
    known = start.multipliers
    x = np.array(start.variables, dtype=np.float64)
    m = np.zeros(lower.size) if known is None else np.concatenate([known.bounds, known.rows])
    status, done = "Maximum_Iterations_Exceeded", 0
    for done in range(most_iterations + 1):
        gradient = np.asarray(nlp.gradient(x, program.parameters)[1]).ravel()
        values, slopes = nlp.jacobian(x, program.parameters)
        rows, c = vstack([eye(size), _sparse(slopes)], "csr"), np.concatenate([x, np.asarray(values).ravel()])
        above, below = m + c - upper > 0.0, m + c - lower < 0.0
        active = np.flatnonzero(above | below | (lower == upper))
        missed = np.where(above, c - upper, c - lower)[active]
        slope = gradient + rows.T @ m
        residual = max(np.abs(np.concatenate([slope, missed])).max(), np.abs(np.delete(m, active)).max(initial=0.0))
        if progress is not None:
            progress(ProgressReport(what="iteration", done=done, quantity="residual", value=float(residual)))
        if residual < tolerance or not residual < DIVERGED:
            status = "Converged" if residual < tolerance else "Diverged"
            break
        half = _sparse(nlp.hessian(x, program.parameters, 1.0, m[size:]))
        curvature = half + half.T - csc_matrix(np.diag(half.diagonal()))
        A = rows[active]
        equations = bmat([[curvature, A.T], [A, -REGULAR * eye(active.size)]], "csc")
        step = splu(equations).solve(-np.concatenate([gradient, missed + REGULAR * m[active]]))
        x, m = x + step[:size], np.zeros(m.size)
        m[active] = step[size:]
    return finished(
        program,
        x,
        solver="active set",
        status=status,
        solved=status == "Converged",
        iterations=done,
        seconds=time.perf_counter() - began,
        multipliers=(m[:size], m[size:]),
    )


def _sparse(matrix: object) -> csc_matrix:
    return csc_matrix(matrix.sparse())  # type: ignore[attr-defined]


SOLVERS.register("active set", active_set)
