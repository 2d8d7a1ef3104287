"""Many gaits of one structure: each problem starts from the solution before it, multipliers included."""

from __future__ import annotations

import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from amble.amounts import check_amount
from amble.errors import InputError
from amble.gait import Gait
from amble.progress import Progress
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.problem import GaitProblem
from amble.synthesis.program import build_program
from amble.synthesis.result import to_gait
from amble.synthesis.solve import MOST_ITERATIONS, Start, ipopt, solve_near
from amble.synthesis.synthesize import require_independent_rows


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of one problem.

    Attributes:
        problem: the problem.
        gait: its gait; None where it was not solved.
        status: the solver's last word, and the worst violated row where there is one.
        iterations: of all tries together.
        seconds: wall time of all tries, with building, s.
        warm: whether the solution before it was the start that led to the gait.
        projected: how many values of the last start lay outside their bounds and were moved onto them.
    """

    problem: GaitProblem
    gait: Gait | None
    status: str
    iterations: int
    seconds: float
    warm: bool
    projected: int


def sweep(
    problems: Sequence[GaitProblem],
    tolerance: float = 1e-6,
    most_iterations: int = 200,
    progress: Progress | None = None,
) -> Iterator[Outcome]:
    """Solve problems that differ in speed, ground and limits only, one after the other.

    Order them so that neighbours are alike. What does not converge from the last solution is tried once more from a
    walk of its own; what fails then is reported, and the next problem starts from the last solution that there is.

    Args:
        problems: the problems.
        tolerance: the solver's tolerance on the scaled problem.
        most_iterations: give up a problem after so many.
        progress: called after every iteration.

    Raises:
        InputError: the problems have different structures, or the iterations are not from 1 to 1,000,000.
        NotSolvedError: equality rows depend on each other.
    """
    check_amount("iterations", most_iterations, 1, MOST_ITERATIONS)
    known: Start | None = None
    rows: tuple[str, ...] | None = None
    for problem in problems:
        began = time.perf_counter()
        program = build_program(problem, len(problems))
        natural = initial_guess(problem, program.layout)
        start = natural / program.layout.scale
        if rows is None:
            require_independent_rows(program, natural)
            rows = program.program.row_names
        if program.program.row_names != rows or (known is not None and known.variables.size != start.size):
            raise InputError("a sweep goes through problems of one structure: the same stances, outputs, law and mesh")
        last = solve_near(ipopt, program, known, Start(start), tolerance, most_iterations, progress)
        known = Start(last.variables, last.multipliers) if last.solved else known
        yield Outcome(
            problem=problem,
            gait=to_gait(problem, program.layout, last) if last.solved else None,
            status=last.report.status + (f", worst {last.rows[0].name}" if last.rows else ""),
            iterations=last.report.iterations,
            seconds=time.perf_counter() - began,
            warm=last.solved and last.warm,
            projected=last.projected,
        )
