"""Solving from a neighbour's solution first."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from amble.progress import Progress
from amble.synthesis.program import GaitProgram
from amble.synthesis.solve import Solution, Solver, Start

WARM_ITERATIONS = 40
"""A warm start that needs more was not near: ASTRo's amble from 0.2 to 0.25 m/s takes 14, a cold start 36."""


def solve_near(
    solve: Solver,
    program: GaitProgram,
    near: Start | None,
    far: Callable[[], Start],
    tolerance: float,
    most_iterations: int,
    progress: Progress | None = None,
) -> Solution:
    """Solve from a neighbour's solution with its multipliers; where it was not near, once more from another start.

    Args:
        solve: the solver.
        program: the transcribed problem.
        near: a neighbour's solution, with its multipliers where they fit; None where there is none.
        far: returns the other start, which needs no multipliers.
        tolerance: IPOPT's overall tolerance on the scaled problem.
        most_iterations: give up after so many in both tries together.
        progress: called after every iteration.

    Returns:
        The last try, with the iterations and seconds of both.
    """
    if near is None:
        return solve(program, far(), tolerance, most_iterations, progress)
    few = most_iterations if near.multipliers is None else min(most_iterations, WARM_ITERATIONS)
    first = solve(program, near, tolerance, few, progress)
    left = most_iterations - first.report.iterations
    if first.solved or left <= 0:
        return first
    second = solve(program, replace(far(), multipliers=None), tolerance, left, progress)
    report = replace(
        second.report,
        iterations=first.report.iterations + second.report.iterations,
        seconds=first.report.seconds + second.report.seconds,
    )
    return replace(second, report=report)
