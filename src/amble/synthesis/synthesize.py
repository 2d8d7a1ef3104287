"""From a gait problem to a gait."""

from __future__ import annotations

from amble.errors import NotSolvedError
from amble.gait import Gait, LagrangeMultipliers
from amble.progress import Progress
from amble.synthesis.doctor import require_possible
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.problem import GaitProblem
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.rank import on_coarse_mesh, require_full_rank
from amble.synthesis.result import from_gait, to_gait
from amble.synthesis.solve import SOLVERS, Solution, Start, solve_near


class GaitNotSolvedError(NotSolvedError):
    """The solver stopped without a solution.

    Attributes:
        last: the last iterate, as a gait that violates the rows of the error.
    """

    def __init__(self, solution: Solution, last: Gait) -> None:
        status, moved = solution.report.status, solution.projected
        status += f"; {moved} start values lay outside their bounds and were moved onto them" if moved else ""
        super().__init__(status, solution.rows)
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
        most_iterations: give up after so many. With multipliers the first 40 are a try with them, the rest one without.
        progress: called after every iteration.
        solver: name of a registered solver.

    Raises:
        UnknownNameError: there is no solver of that name.
        InputError: the problem cannot have a solution (``require_possible``).
        GaitNotSolvedError: the solver stopped without a solution; the error carries the violated rows and the last
            iterate.
        NotSolvedError: equality rows of the problem depend on each other.
    """
    run = SOLVERS[solver]
    require_possible(problem)
    program = build_program(problem)
    layout = program.layout
    natural = initial_guess(problem, layout) if start is None else from_gait(problem, start, layout)
    require_full_rank(*on_coarse_mesh(program, natural))
    multipliers = None if start is None else _fitting(start.multipliers, program)
    begin = Start(natural / layout.scale, multipliers)
    solution = solve_near(run, program, begin, begin, tolerance, most_iterations, progress)
    gait = to_gait(problem, layout, solution)
    if not solution.solved:
        raise GaitNotSolvedError(solution, gait)
    return gait


def _fitting(multipliers: LagrangeMultipliers | None, program: GaitProgram) -> LagrangeMultipliers | None:
    """LagrangeMultipliers of a program with as many variables and rows; None for those of another mesh."""
    if multipliers is None:
        return None
    sizes = multipliers.bounds.size, multipliers.rows.size
    return multipliers if sizes == (program.lower.size, program.program.lower.size) else None
