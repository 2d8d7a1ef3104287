"""From a gait problem to a gait."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from amble.errors import NotSolvedError, Row
from amble.gait import Gait, LagrangeMultipliers
from amble.progress import Progress
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.problem import GaitProblem
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.rank import on_coarse_mesh, require_full_rank
from amble.synthesis.result import from_gait, to_gait
from amble.synthesis.solve import SOLVERS, WARM_ITERATIONS, Solution, Solver
from amble.types import Vector


class GaitNotSolvedError(NotSolvedError):
    """The solver stopped without a solution.

    Attributes:
        last: the last iterate, as a gait that violates the rows of the error.
    """

    def __init__(self, status: str, rows: Sequence[Row], last: Gait) -> None:
        super().__init__(status, rows)
        self.last = last


def synthesize(
    problem: GaitProblem,
    start: Gait | None = None,
    tolerance: float = 1e-8,
    most_iterations: int = 500,
    progress: Progress | None = None,
    *,
    solver: str = "ipopt",
) -> Gait:
    """Find the gait of a problem.

    Args:
        problem: the problem.
        start: a gait of the same pattern to start from, with its multipliers where it has as many intervals; by default
            a walk that kinematics alone draws.
        tolerance: the solver's tolerance on the scaled problem.
        most_iterations: give up after so many.
        progress: called after every iteration.
        solver: name of a registered solver.

    Raises:
        UnknownNameError: there is no solver of that name.
        GaitNotSolvedError: the solver stopped without a solution; the error carries the violated rows and the last
            iterate.
        NotSolvedError: equality rows of the problem depend on each other.
    """
    run = SOLVERS[solver]
    program = build_program(problem)
    layout = program.layout
    natural = initial_guess(problem, layout) if start is None else from_gait(start, layout)
    require_full_rank(*on_coarse_mesh(program, natural))
    multipliers = None if start is None else _fitting(start.multipliers, program)
    solution = _solve(run, program, natural / layout.scale, multipliers, tolerance, most_iterations, progress)
    gait = to_gait(problem, layout, solution)
    if not solution.solved:
        raise GaitNotSolvedError(solution.report.status, solution.rows, gait)
    return gait


def _solve(
    solve: Solver,
    program: GaitProgram,
    start: Vector,
    multipliers: LagrangeMultipliers | None,
    tolerance: float,
    most_iterations: int,
    progress: Progress | None,
) -> Solution:
    """Solve with multipliers first; where the start was not near, from the same start without them."""
    inside = np.clip(start, program.lower, program.upper)
    if multipliers is None:
        return solve(program, inside, tolerance, most_iterations, None, progress)
    near = solve(program, inside, tolerance, min(most_iterations, WARM_ITERATIONS), multipliers, progress)
    left = most_iterations - near.report.iterations
    if near.solved or left <= 0:
        return near
    again = solve(program, inside, tolerance, left, None, progress)
    report = replace(
        again.report,
        iterations=near.report.iterations + again.report.iterations,
        seconds=near.report.seconds + again.report.seconds,
    )
    return replace(again, report=report)


def _fitting(multipliers: LagrangeMultipliers | None, program: GaitProgram) -> LagrangeMultipliers | None:
    """LagrangeMultipliers of a program with as many variables and rows; None for those of another mesh."""
    if multipliers is None:
        return None
    sizes = multipliers.bounds.size, multipliers.rows.size
    return multipliers if sizes == (program.lower.size, program.program.lower.size) else None
