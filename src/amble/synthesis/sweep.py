"""Many gaits of one structure: each problem starts from the gait before it, multipliers included."""

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
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.result import from_gait, to_gait
from amble.synthesis.solve import MOST_ITERATIONS, SOLVERS, Start
from amble.synthesis.solve_near import solve_near
from amble.synthesis.synthesize import fitting, require_independent_rows


@dataclass(frozen=True, kw_only=True)
class Outcome:
    """What became of one problem.

    Attributes:
        problem: the problem.
        gait: its gait; None where it was not solved.
        status: the solver's last word, and the worst violated row where there is one.
        iterations: of all tries together.
        seconds: wall time of all tries, with building, s.
        warm: whether the neighbour was the start that led to the gait.
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

    Order them so that neighbours are alike. What does not converge from the last gait is tried once more from a
    walk of its own; what fails then is reported, and the next problem starts from the last gait that there is.
    ``build_library`` does the same over axes, in several processes, with files.

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
    known: Gait | None = None
    rows: tuple[str, ...] | None = None
    for problem in problems:
        began = time.perf_counter()
        program = build_program(problem, len(problems))
        rows = rows or program.program.row_names
        if program.program.row_names != rows:
            raise InputError("a sweep goes through problems of one structure: the same stances, outputs, law and mesh")
        outcome = solve_from(program, known, tolerance, most_iterations, progress, began=began)
        known = outcome.gait or known
        yield outcome


def solve_from(
    program: GaitProgram,
    near: Gait | None,
    tolerance: float,
    most_iterations: int,
    progress: Progress | None = None,
    *,
    solver: str = "ipopt",
    began: float | None = None,
) -> Outcome:
    """Solve a problem from a neighbour's gait; where that does not converge, once more from a kinematic walk.

    Args:
        program: the transcribed problem.
        near: a gait of the same stances and outputs; None where there is none.
        tolerance: the solver's tolerance on the scaled problem.
        most_iterations: give up after so many in both tries together.
        progress: called after every iteration.
        solver: name of a registered solver.
        began: ``time.perf_counter`` when the work on the problem began; now by default.

    Raises:
        InputError: the gait has other stances or outputs.
        NotSolvedError: equality rows depend on each other.
    """
    since = time.perf_counter() if began is None else began
    problem, layout = program.problem, program.layout

    def walk() -> Start:
        return Start(initial_guess(problem, layout) / layout.scale)

    start = None
    if near is not None:
        start = Start(from_gait(problem, near, layout) / layout.scale, fitting(near.multipliers, program))
    first = start or walk()
    require_independent_rows(program, first.variables * layout.scale)
    far = walk if start else lambda: first
    last = solve_near(SOLVERS[solver], program, start, far, tolerance, most_iterations, progress)
    return Outcome(
        problem=problem,
        gait=to_gait(problem, layout, last) if last.solved else None,
        status=last.report.status + (f", worst {last.rows[0].name}" if last.rows else ""),
        iterations=last.report.iterations,
        seconds=time.perf_counter() - since,
        warm=last.solved and last.warm,
        projected=last.projected,
    )
