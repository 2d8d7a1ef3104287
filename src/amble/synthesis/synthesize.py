"""From a gait problem to a gait."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amble.errors import NotSolvedError, Row
from amble.gait import Gait
from amble.synthesis.guess import walking
from amble.synthesis.problem import GaitProblem
from amble.synthesis.program import build_program
from amble.synthesis.rank import on_coarse_mesh, require_full_rank
from amble.synthesis.result import from_gait, to_gait
from amble.synthesis.solve import Progress, solve


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
) -> Gait:
    """Find the gait of a problem.

    Args:
        problem: the problem.
        start: a gait of the same pattern to start from; by default a walk that kinematics alone draws.
        tolerance: the solver's tolerance on the scaled problem.
        most_iterations: give up after so many.
        progress: called after every iteration.

    Raises:
        GaitNotSolvedError: the solver stopped without a solution; the error carries the violated rows and the last
            iterate.
        NotSolvedError: equality rows of the problem depend on each other.
    """
    program = build_program(problem)
    layout = program.layout
    natural = walking(problem, layout) if start is None else from_gait(start, layout)
    require_full_rank(*on_coarse_mesh(program, natural))
    solution = solve(
        program,
        np.clip(natural / layout.scale, program.lower, program.upper),
        tolerance,
        most_iterations,
        progress=progress,
    )
    gait = to_gait(problem, layout, solution)
    if not solution.solved:
        raise GaitNotSolvedError(solution.report.status, solution.rows, gait)
    return gait
