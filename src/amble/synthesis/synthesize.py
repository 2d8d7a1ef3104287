"""From a gait problem to a gait, by several ways where the first finds none."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial

from amble.amounts import check_amount
from amble.control import DomainOutputs, Outputs
from amble.control.outputs import least_share, left_out_along
from amble.errors import NotSolvedError
from amble.gait import Gait, LagrangeMultipliers
from amble.progress import Progress
from amble.robot.natural_units import velocity_unit
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.landing_rows import SLOW_RELEASE, released_slowly, releases
from amble.synthesis.possible import require_possible
from amble.synthesis.problem import GaitProblem
from amble.synthesis.program import GaitProgram, Structure, build_program, on_coarse_mesh, require_full_rank
from amble.synthesis.result import from_gait, to_gait
from amble.synthesis.solve import (
    MOST_ITERATIONS,
    SOLVERS,
    Solution,
    Solver,
    Start,
    ipopt,
    ipopt_mumps,
    ipopt_structured,
)
from amble.synthesis.solve_near import solve_near
from amble.types import Vector

logger = logging.getLogger("amble")

COARSER, FIRST_TRY, LATER_TRY = 17, 250, 125
"""Nodes from which what is not solved in so many iterations is tried from half the intervals, each in so many more."""

FAST_LANDING = 10.0
"""Velocity of landing feet in sqrt(g l) that no gait reaches."""

SINGULAR = 0.1
"""Share of an internal torque that the joints left out hold (``least_share``), below which other outputs are chosen."""


class GaitNotSolvedError(NotSolvedError):
    """The solver stopped without a solution.

    Attributes:
        last: the last iterate, as a gait that violates the rows of the error.
        iterations: how many it took.
        refused: why the structured solver refused a KKT system; empty where it did not.
    """

    def __init__(self, solution: Solution, last: Gait) -> None:
        status, moved = solution.report.status, solution.projected
        status += f"; {moved} start values lay outside their bounds and were moved onto them" if moved else ""
        super().__init__(status, solution.rows)
        self.last = last
        self.iterations, self.refused = solution.report.iterations, solution.refused


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
            Without a start what is not solved after 250 is tried by way of half the intervals with the rest
            (``_by_several_ways``); where the structured solver refused a system, by MUMPS last.
        progress: called after every iteration.
        solver: name of a registered solver.

    Raises:
        UnknownNameError: there is no solver of that name.
        InputError: the iterations are not from 1 to 1,000,000, or the problem cannot have a solution
            (``require_possible``).
        GaitNotSolvedError: the solver stopped without a solution; the error carries the violated rows and the last
            iterate.
        NotSolvedError: equality rows of the problem depend on each other.
    """
    run = SOLVERS[solver]
    check_amount("iterations", most_iterations, 1, MOST_ITERATIONS)
    require_possible(problem)
    if start is not None and released_slowly(problem, start):
        problem = replace(problem, release=min(problem.release, SLOW_RELEASE))
    by_half = start is None and problem.nodes >= COARSER and most_iterations > FIRST_TRY
    how = (tolerance, most_iterations, progress)
    gait = _by_several_ways(problem, run, *how) if by_half else _solved(problem, start, run, *how)
    better = regular_outputs(problem, gait)
    if better is problem.outputs:
        return gait
    again = replace(problem, outputs=better, outputs_by_default=False)
    return synthesize(again, replace(gait, multipliers=None), tolerance, most_iterations, progress, solver=solver)


def _solved(
    problem: GaitProblem,
    start: Gait | None,
    run: Solver,
    tolerance: float,
    most_iterations: int,
    progress: Progress | None,
) -> Gait:
    """Solve once, from a gait or the kinematic walk; errors as ``synthesize``."""
    program = build_program(problem)
    layout = program.layout
    natural = initial_guess(problem, layout) if start is None else from_gait(problem, start, layout)
    require_independent_rows(program, natural)
    multipliers = None if start is None else fitting(start.multipliers, program)
    begin = Start(natural / layout.scale, multipliers)
    near = None if multipliers is None else begin
    solution = solve_near(run, program, near, lambda: begin, tolerance, most_iterations, progress)
    gait = to_gait(problem, layout, solution)
    if not solution.solved:
        raise GaitNotSolvedError(solution, gait)
    return gait


class _Tries:
    """Solves for one problem that share their iterations."""

    def __init__(self, tolerance: float, most_iterations: int, progress: Progress | None) -> None:
        self.tolerance, self.left, self.progress = tolerance, most_iterations, progress

    def solve(self, problem: GaitProblem, start: Gait | None, run: Solver, most: int) -> Gait:
        """Solve once, with at most so many iterations; errors as ``synthesize``."""
        begin = None if start is None else replace(start, multipliers=None)
        try:
            gait = _solved(problem, begin, run, self.tolerance, max(min(most, self.left), 1), self.progress)
        except GaitNotSolvedError as error:
            self.left -= error.iterations
            raise
        self.left -= gait.solver.iterations
        return gait


def _by_several_ways(
    problem: GaitProblem, run: Solver, tolerance: float, most_iterations: int, progress: Progress | None
) -> Gait:
    """Solve on the whole mesh; else by way of half the intervals, another way through the same problem and a cheap one.

    Half the intervals are solved from the kinematic walk, then from a gait whose feet may land as fast as they like:
    HyQ's trot, refused on 15 intervals, is solved on 8, Vision60's bound only from such a gait. Then feet that a
    landing releases may leave slowly (``SLOW_RELEASE``): the paces of both are not solved otherwise. Where the
    structured solver refused a system MUMPS comes last: a system takes it many times as long.

    Raises:
        GaitNotSolvedError: no way helps; the error is that of the whole mesh.
    """
    quick = ipopt_structured if run is ipopt else run
    tries = _Tries(tolerance, most_iterations, progress)
    try:
        return tries.solve(problem, None, quick, FIRST_TRY)
    except GaitNotSolvedError as error:
        unsolved = error
    for asked, way in _ways(problem):
        half = replace(asked, intervals=(problem.intervals + 1) // 2)
        try:
            start = tries.solve(_eased(half), None, quick, LATER_TRY) if way == "eased" else None
            coarse = None if way == "whole" else tries.solve(half, start, quick, LATER_TRY)
            found = tries.solve(asked, coarse, quick, LATER_TRY)
        except NotSolvedError:
            continue
        logger.warning(
            "not solved on %d intervals from the kinematic walk (%s), but %s%s",
            problem.intervals,
            unsolved.status,
            "so" if way == "whole" else f"from the gait of {half.intervals} intervals",
            "" if asked is problem else f": feet that a landing releases rise at {asked.release:g} sqrt(g l) at least",
        )
        return found
    if not unsolved.refused or run is not ipopt:
        raise unsolved
    try:
        return tries.solve(problem, None, partial(ipopt_mumps, reason=unsolved.refused), most_iterations)
    except GaitNotSolvedError:
        raise unsolved from None


def _ways(problem: GaitProblem) -> list[tuple[GaitProblem, str]]:
    """What is tried after the kinematic walk on the whole mesh: a problem, and from what.

    From half the intervals, from half the intervals of an eased gait, or from the walk on the whole mesh.
    """
    ways = [(problem, "half"), (problem, "eased")]
    if releases(problem.pattern) and problem.release > SLOW_RELEASE:
        slow = replace(problem, release=SLOW_RELEASE)
        ways += [(slow, "half"), (slow, "whole")]
    return ways


def _eased(problem: GaitProblem) -> GaitProblem:
    """Leave the velocity open at which feet land, but that they come down."""
    fast = FAST_LANDING * velocity_unit(problem.pattern.robot)
    landing = ((-fast, fast), (-fast, fast), (-fast, problem.limits.touchdown_velocity[2][1]))
    return replace(problem, limits=replace(problem.limits, touchdown_velocity=landing))


def regular_outputs(problem: GaitProblem, gait: Gait) -> Outputs:
    """Return outputs that can be decoupled all along a gait: those of the problem where they can, or were asked for.

    Those by default are chosen at one posture, and a motion goes through others. What is changed, or should be, is
    said.
    """
    pattern, found, said = problem.pattern, list[DomainOutputs](), list[str]()
    for domain, known in zip(problem.outputs.domains, gait.domains, strict=True):
        stance, controlled = pattern.stance(domain.domain), domain.coordinates
        found.append(domain)
        if not set(pattern.robot.joint_names) >= set(controlled):
            continue  # a base angle is among them, which was asked for
        share = least_share(pattern, stance, controlled, known.positions)
        if share >= SINGULAR:
            continue
        others = left_out_along(pattern, stance, controlled, known.positions)
        said.append(f"in {domain.domain} to a share of {share:.2g}; left out there should be {', '.join(others)}")
        kept = tuple(joint for joint in pattern.robot.joint_names if joint not in others)
        found[-1] = DomainOutputs(domain.domain, kept)
    if not said:
        return problem.outputs
    asked = "" if problem.outputs_by_default else " (joint_outputs, free; [outputs] free)"
    logger.warning("the outputs can hardly be decoupled along the motion, %s%s", "; ".join(said), asked)
    return replace(problem.outputs, domains=tuple(found)) if problem.outputs_by_default else problem.outputs


def require_independent_rows(program: GaitProgram, natural: Vector) -> None:
    """Check once for all programs of a structure that no equality rows depend on each other.

    Args:
        program: the transcribed problem.
        natural: unscaled variables, (n_x,).

    Raises:
        NotSolvedError: names the rows that depend on each other.
    """
    _require_full_rank(Structure.of(program), _Point(natural))


@dataclass(frozen=True)
class _Point:
    """Unscaled variables, (n_x,); all compare equal, since rows that depend on each other do so everywhere."""

    variables: Vector = field(compare=False)


@lru_cache(maxsize=32)
def _require_full_rank(structure: Structure, point: _Point) -> None:
    """A failure is no verdict that is kept."""
    require_full_rank(*on_coarse_mesh(structure.program, point.variables))


def fitting(multipliers: LagrangeMultipliers | None, program: GaitProgram) -> LagrangeMultipliers | None:
    """LagrangeMultipliers of a program with as many variables and rows; None for those of another mesh."""
    if multipliers is None:
        return None
    sizes = multipliers.bounds.size, multipliers.rows.size
    return multipliers if sizes == (program.lower.size, program.program.lower.size) else None
