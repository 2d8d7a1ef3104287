"""The gait problem the plain way: one casadi NLP in natural units, derivatives interpreted, IPOPT's own settings.

The same rows, bounds and start as amble's, so that only the way of solving differs.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from amble.synthesis.block import Block
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.problem import GaitProblem
from amble.synthesis.program import GaitProgram, _blocks, build_program


@dataclass(frozen=True)
class Plain:
    """How the plain way went: status, iterations, wall time with building, s, and the objective."""

    status: str
    iterations: int
    seconds: float
    objective: float


def solve_plainly(problem: GaitProblem, tolerance: float, most_seconds: float) -> Plain:
    """Build and solve a gait problem; gives up after a wall time."""
    program = build_program(problem)  # for rows and bounds; its time does not count
    start = initial_guess(problem, program.layout)
    began = time.perf_counter()
    nlp = _nlp(program, _blocks(problem, program.layout))
    options = {"print_level": 0, "sb": "yes", "tol": tolerance, "max_iter": 3000, "max_wall_time": most_seconds}
    solver = ca.nlpsol("plain", "ipopt", nlp, {"ipopt": options, "print_time": False, "error_on_fail": False})
    scale = program.layout.scale
    lower, upper = program.lower * scale, program.upper * scale
    result: dict[str, Any] = solver(
        x0=np.clip(start, lower, upper),
        p=program.parameters,
        lbx=lower,
        ubx=upper,
        lbg=program.program.lower * program.program.row_scale,
        ubg=program.program.upper * program.program.row_scale,
    )
    seconds = time.perf_counter() - began
    stats = solver.stats()
    return Plain(str(stats["return_status"]), int(stats["iter_count"]), seconds, float(result["f"]))


def _nlp(program: GaitProgram, blocks: list[Block]) -> dict[str, ca.MX]:
    x, p = ca.MX.sym("x", program.layout.size), ca.MX.sym("p", program.parameters.size)
    rows, costs = [], []
    for block in blocks:
        function = ca.Function(
            block.name, [block.variables, block.constants, block.parameters], [block.rows, block.cost]
        )
        for columns, constants in zip(block.columns, block.values, strict=True):
            row, cost = function(x[columns.tolist()], constants, p)
            rows.append(row)
            costs.append(cost)
    return {"x": x, "p": p, "f": sum(costs), "g": ca.vertcat(*rows)}
