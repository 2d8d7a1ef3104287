"""One step of the bilinear matrix inequality problem of orbital stabilisation, by a linear matrix inequality.

The problem (Akbari Hamed et al. 2014; docs/theory/stability.md, eq. 17 to 19): with A(theta + d) ~ A_0 + sum d_i A_i,
minimise -w mu + gamma subject to [[W, A(d) W], [., (1 - mu) W]] > 0 and [[1, d], [d^T, gamma]] >= 0; then
rho < sqrt(1 - mu).
It is bilinear in W and d. Here W comes from a Lyapunov equation of the present A_0, and d from the linear matrix
inequality that is left: with W = L L^T and M(d) = L^-1 A(d) L it says that the norm of M(d) is at most
tau = sqrt(1 - mu).
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from amble.errors import NotSolvedError
from amble.stability.weighted_map import WeightedMap
from amble.types import Matrix, Vector

SLACK = 1.15
"""W is that of A_0 scaled to spectral radius 1 / SLACK: nearer 1 it is sharper, and more ill-conditioned."""

TURNS = 2
"""How often W and d take turns within a step."""

SIZE_WEIGHT = 1e-3
"""Weight of gamma = |d|^2 beside tau, the bound on the radius."""


def metric(matrix: Matrix, slack: float = SLACK) -> Matrix:
    """Return L with W = L L^T and W - s^2 A W A^T = 1, where s scales A to spectral radius 1 / slack."""
    from scipy.linalg import cholesky, solve_discrete_lyapunov

    radius = float(np.abs(np.linalg.eigvals(matrix)).max())
    scaled = matrix / (slack * radius)
    solution = solve_discrete_lyapunov(scaled, np.eye(len(matrix)))
    return np.asarray(cholesky(0.5 * (solution + solution.T), lower=True))


def bilinear_step(here: WeightedMap, longest: float) -> tuple[Vector, float]:
    """Return the step d of the weights, |d| <= longest, and the bound tau on the radius that the linear model promises.

    W and d take turns on the same linear model: W of A(0), then of A(d).

    Raises:
        NotSolvedError: the solver of the semidefinite program fails.
    """
    slopes = here.slopes()
    matrix, best = here.matrix, None
    for _ in range(TURNS):
        step, bound = _inequality(here.matrix, slopes, metric(matrix), longest)
        if best is None or bound < best[1]:
            best = (step, bound)
        matrix = here.matrix + np.tensordot(step, slopes, 1)
    assert best is not None
    return best


def _inequality(matrix: Matrix, slopes: NDArray[np.float64], left: Matrix, longest: float) -> tuple[Vector, float]:
    """Solve the linear matrix inequality that a fixed W = L L^T leaves."""
    import cvxpy as cp

    inverse = np.linalg.inv(left)
    base = inverse @ matrix @ left
    turned = np.einsum("ab,ibc,cd->iad", inverse, slopes, left, optimize=True)
    size = len(base)
    step, bound = cp.Variable(len(slopes)), cp.Variable()
    change = cp.reshape(turned.reshape(len(slopes), -1).T @ step, (size, size), order="C")
    moved = base + change
    identity = np.eye(size)
    problem = cp.Problem(
        cp.Minimize(bound + SIZE_WEIGHT * cp.sum_squares(step)),
        [cp.bmat([[bound * identity, moved], [moved.T, bound * identity]]) >> 0, cp.norm(step) <= longest],
    )
    try:
        problem.solve(solver=cp.CLARABEL)
    except cp.error.SolverError as error:
        raise NotSolvedError(f"the matrix inequality step failed: {error}", []) from None
    if problem.status not in ("optimal", "optimal_inaccurate") or step.value is None:
        raise NotSolvedError(f"the matrix inequality step ended with status '{problem.status}'", [])
    return np.asarray(step.value), float(np.asarray(bound.value))
