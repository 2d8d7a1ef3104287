"""Small convex quadratic programs with a fixed number of operations: Mehrotra's predictor and corrector.

Minimise x^T H x / 2 + c^T x subject to G x <= h. No search, no branch, no heap: every step is the same straight-line
code (Nocedal and Wright, Numerical Optimization, algorithm 16.4). Of all iterates the one that misses the optimality
conditions least is returned, so that roundoff after convergence does no harm.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.numerics.linear_algebra import SymmetricFactor

STEPS = 15
"""Data of size one need 7 to 13 steps from a cold start to 1e-10."""

FIRST_GAP = 0.1
"""Complementarity of every row at the start."""

GAP_WEIGHT = 1e5
"""What complementarity counts against residuals: where a multiplier is nearly zero, x errs by the root of the gap."""

CONVERGED = 1e-15
"""Mean complementarity from which on the iterate stays: beyond it, roundoff would lead it astray."""

TO_BOUNDARY = 0.995


@dataclass(frozen=True)
class QuadraticProgram:
    """Data of a program; sparse where its structure is, well scaled by the caller.

    Attributes:
        hessian: H, symmetric positive semidefinite, (n, n); H + G^T G is positive definite.
        cost: c, (n,).
        rows: G, (m, n).
        limits: h, (m,).
    """

    hessian: ca.SX
    cost: ca.SX
    rows: ca.SX
    limits: ca.SX


def minimise(program: QuadraticProgram, start: ca.SX, steps: int = STEPS) -> ca.SX:
    """Return the minimiser x, (n,), where the program has one.

    Args:
        program: the data.
        start: first x, (n,); it need not be feasible.
        steps: number of steps, always all taken.
    """
    step = _step(program.hessian.sparsity(), program.rows.sparsity())
    data = program.hessian, ca.densify(program.cost), program.rows, ca.densify(program.limits)
    slack = ca.fmax(data[3] - data[2] @ start, 1.0)
    x, y, z, best, least = start, slack, FIRST_GAP / slack, start, ca.SX(ca.inf)
    for _ in range(steps):
        # called, not written out: the code of one step serves all
        x, y, z, best, least = step.call([*data, x, y, z, best, least], False, True)
    return best


def _step(hessian: ca.Sparsity, rows: ca.Sparsity) -> ca.Function:
    """One predictor-corrector step of (x, y, z) with G x + y = h, y > 0, z > 0, which also keeps the best x so far."""
    m, n = rows.shape
    H, c = ca.SX.sym("H", hessian), ca.SX.sym("c", n)
    G, h = ca.SX.sym("G", rows), ca.SX.sym("h", m)
    x, y, z = ca.SX.sym("x", n), ca.SX.sym("y", m), ca.SX.sym("z", m)
    best, least = ca.SX.sym("best", n), ca.SX.sym("least")
    dual = H @ x + c + G.T @ z
    primal = G @ x + y - h
    gap = ca.dot(y, z) / m
    factor = SymmetricFactor.of(H + G.T @ ((z / y) * G))

    def newton(target: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Step that makes both residuals vanish and y z change by -target, all to first order."""
        dx = factor.solve(-dual - G.T @ ((z * primal - target) / y))
        dy = -primal - G @ dx
        return dx, dy, -(target + z * dy) / y

    _, dy, dz = newton(y * z)
    length = _longest(ca.vertcat(y, z), ca.vertcat(dy, dz), 1.0)
    after = ca.dot(y + length * dy, z + length * dz) / m
    centring = after / gap  # its cube, the usual choice, jams at one state in a thousand; this at none of 3,600
    dx, dy, dz = newton(y * z + dy * dz - centring * gap)
    length = _longest(ca.vertcat(y, z), ca.vertcat(dy, dz), TO_BOUNDARY)
    # sums, not largest entries: the maximum of C ignores what is not a number
    missed = GAP_WEIGHT * gap + ca.norm_1(primal) + ca.norm_1(dual)
    better = ca.logic_and(missed < least, gap > 0.0)
    kept = [ca.if_else(better, x, best), ca.if_else(better, missed, least)]
    going = gap > CONVERGED
    moved = [ca.if_else(going, old + length * change, old) for old, change in ((x, dx), (y, dy), (z, dz))]
    return ca.Function("interior_point_step", [H, c, G, h, x, y, z, best, least], [*moved, *kept])


def _longest(values: ca.SX, change: ca.SX, share: float) -> ca.SX:
    """Longest step up to 1 that keeps ``values`` positive, times ``share`` where they bound it."""
    ratios = ca.if_else(change < 0, -values / change, 1.0 / share)
    return ca.fmin(1.0, share * ca.mmin(ratios))
