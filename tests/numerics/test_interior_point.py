"""The fixed number of steps against a solver that takes as many as it needs."""

from __future__ import annotations

import casadi as ca
import clarabel
import numpy as np
import pytest
from scipy import sparse

from amble.numerics.interior_point import QuadraticProgram, minimise


def solve(H: np.ndarray, c: np.ndarray, G: np.ndarray, h: np.ndarray) -> np.ndarray:
    settings = clarabel.DefaultSettings()
    settings.verbose = False
    settings.tol_gap_abs = settings.tol_gap_rel = settings.tol_feas = 1e-11
    quadratic, rows = sparse.csc_matrix(np.triu(H)), sparse.csc_matrix(G)
    found = clarabel.DefaultSolver(quadratic, c, rows, h, [clarabel.NonnegativeConeT(len(h))], settings).solve()
    assert str(found.status) == "Solved"
    return np.array(found.x)


def function(n: int, m: int) -> ca.Function:
    H, c = ca.SX.sym("H", n, n), ca.SX.sym("c", n)
    G, h, x = ca.SX.sym("G", m, n), ca.SX.sym("h", m), ca.SX.sym("x", n)
    return ca.Function("minimise", [H, c, G, h, x], [minimise(QuadraticProgram(H, c, G, h), x)])


@pytest.mark.parametrize(("n", "m"), [(1, 4), (3, 20), (6, 44)])
def test_random_programs(n: int, m: int) -> None:
    generator = np.random.default_rng(n)
    unrolled = function(n, m)
    for _ in range(200):
        root = generator.normal(size=(n, n))
        H, c = root @ root.T / n + 0.1 * np.eye(n), generator.normal(size=n)
        G, inside = generator.normal(size=(m, n)), generator.normal(size=n)
        h = G @ inside + generator.uniform(0.0, 1.0, m)  # feasible, the start perhaps not
        x = np.asarray(unrolled(H, c, G, h, np.zeros(n)).full()).ravel()
        # a gap of 1e-11 in the oracle leaves its root open where a multiplier is nearly zero
        assert np.max(np.abs(x - solve(H, c, G, h))) < 1e-5
        assert np.max(G @ x - h) < 1e-9


@pytest.mark.parametrize("n", [2, 4])
def test_linear_programs(n: int) -> None:
    generator = np.random.default_rng(n)
    m = 5 * n
    unrolled = function(n, m + 2 * n)
    for _ in range(200):
        c = generator.normal(size=n)
        G = np.vstack([generator.normal(size=(m, n)), np.eye(n), -np.eye(n)])
        h = np.concatenate([generator.uniform(0.1, 1.0, m), np.full(2 * n, 3.0)])
        x = np.asarray(unrolled(np.zeros((n, n)), c, G, h, np.zeros(n)).full()).ravel()
        assert c @ x == pytest.approx(c @ solve(np.zeros((n, n)), c, G, h), abs=1e-8)
