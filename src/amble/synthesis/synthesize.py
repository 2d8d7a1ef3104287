"""From a gait problem to a gait; what no gait of a problem can do is said before a solver spends minutes on it."""

from __future__ import annotations

import logging
from dataclasses import dataclass, field, replace
from functools import lru_cache

import numpy as np

from amble.amounts import check_amount
from amble.control import DomainOutputs, Outputs
from amble.control.outputs import least_share, left_out_along
from amble.errors import InputError, NotSolvedError, listed, printable
from amble.gait import Gait, LagrangeMultipliers
from amble.progress import Progress
from amble.robot.kinematics import foot_position
from amble.robot.natural_units import velocity_unit
from amble.robot.plausibility import doubts
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.problem import GaitProblem
from amble.synthesis.program import GaitProgram, Structure, build_program, on_coarse_mesh, require_full_rank
from amble.synthesis.result import from_gait, to_gait
from amble.synthesis.solve import MOST_ITERATIONS, SOLVERS, Solution, Solver, Start, ipopt, ipopt_structured
from amble.synthesis.solve_near import solve_near
from amble.types import Vector

logger = logging.getLogger("amble")

OFF_GROUND = 0.25
"""Distance of a foot from the ground at the posture, as a share of the leg length, from which no solver starts."""


def require_possible(problem: GaitProblem) -> None:
    """Refuse a problem that cannot have a solution or a start; log what is odd about its robot and posture.

    Raises:
        InputError: the base must keep higher than legs are long, feet are far off the ground at the posture, or the
            legs cannot move the feet of a stance against each other.
    """
    robot, limits = problem.pattern.robot, problem.limits
    lowest = limits.positions.get("z", (-np.inf, np.inf))[0]
    if lowest - float(problem.pattern.ground.height(0.0, 0.0)) > robot.leg_length:
        raise InputError(
            f"the base must keep above {lowest:g} m (limits of z), but no leg of robot '{robot.name}' is longer than "
            f"{robot.leg_length:.3g} m"
        )
    _require_feet_near_ground(problem)
    _require_free_legs(problem)
    for doubt in (*doubts(robot), *_outside(problem)):
        logger.warning("%s", printable(doubt))


def _require_feet_near_ground(problem: GaitProblem) -> None:
    robot, ground = problem.pattern.robot, problem.pattern.ground
    q = problem.posture.coordinates(robot)
    places = [np.asarray(foot_position(robot, foot, q)).ravel() for foot in robot.foot_names]
    base = float(ground.height(0.0, 0.0))
    heights = {
        foot: float(place[2] + base - ground.height(place[0], place[1]))
        for foot, place in zip(robot.foot_names, places, strict=True)
    }
    foot = max(heights, key=lambda name: abs(heights[name]))
    if abs(heights[foot]) > OFF_GROUND * robot.leg_length:
        fitting = problem.posture.height - float(np.median(list(heights.values())))
        raise InputError(
            f"at the posture foot '{foot}' is {heights[foot]:.3g} m above the ground; with these angles the height of "
            f"the posture would be about {fitting:.3g} m"
        )


def _require_free_legs(problem: GaitProblem) -> None:
    """Refuse a stance in which contacts depend on each other: no torque determines the forces along such directions."""
    pattern = problem.pattern
    q = problem.posture.coordinates(pattern.robot)
    for stance in pattern.solved:
        tied = pattern.contacts(stance).dependent(tuple(map(float, q)))
        if tied:
            raise InputError(
                f"robot '{pattern.robot.name}' cannot stand on {', '.join(stance.feet)} (stance '{stance.name}'): its "
                f"legs have no joints that move these feet against each other, so that {listed(tied)} "
                "depend on each other and no torque determines the forces there; choose a gait on other feet"
            )


def _outside(problem: GaitProblem) -> list[str]:
    """What of the posture lies outside its bounds: the solver starts inside them."""
    robot, found = problem.pattern.robot, []
    q = problem.posture.coordinates(robot)
    for name, (low, high) in problem.limits.positions.items():
        value = float(q[robot.coordinate_index(name)])
        if not low <= value <= high:
            found.append(f"the posture has {name} at {value:.4g}, outside {low:.4g} to {high:.4g}; it is moved inside")
    return found


COARSER, FIRST_TRY, LATER_TRY = 8, 250, 125
"""Intervals from which what is not solved in so many iterations is tried from half of them, each in so many more."""

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
    by_half = start is None and problem.intervals >= COARSER and most_iterations > FIRST_TRY
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
    HyQ's trot, refused on 15 intervals, is solved on 8, Vision60's bound only from such a gait. Where the structured
    solver refused a system MUMPS comes last: a system takes it many times as long.

    Raises:
        GaitNotSolvedError: no way helps; the error is that of the whole mesh.
    """
    quick = ipopt_structured if run is ipopt else run
    tries = _Tries(tolerance, most_iterations, progress)
    try:
        return tries.solve(problem, None, quick, FIRST_TRY)
    except GaitNotSolvedError as error:
        unsolved = error
    half = replace(problem, intervals=(problem.intervals + 1) // 2)
    for eased in (False, True):
        try:
            start = tries.solve(_eased(half), None, quick, LATER_TRY) if eased else None
            coarse = tries.solve(half, start, quick, LATER_TRY)
            found = tries.solve(problem, coarse, quick, LATER_TRY)
        except NotSolvedError:
            continue
        logger.warning(
            "not solved on %d intervals from the kinematic walk (%s), but from the gait of %d intervals",
            problem.intervals,
            unsolved.status,
            half.intervals,
        )
        return found
    if not unsolved.refused:
        raise unsolved
    return tries.solve(problem, None, run, most_iterations)


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
