"""From a specification to a gait: read once, solved, refined until it passes its check, or what fails is said."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace
from importlib import resources
from pathlib import Path

from amble.errors import WorkError
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.progress import Progress
from amble.residual import worst_first
from amble.stability.closed_loop_orbit import bare_fixed_point
from amble.stability.orbit_conditions import RECORD, entry_rows
from amble.synthesis.problem import GaitProblem
from amble.synthesis.refine import refine
from amble.synthesis.specification import SolverSection, Specification, read_specification
from amble.synthesis.specified import problem_of
from amble.synthesis.synthesize import synthesize
from amble.verification.check import check
from amble.verification.residuals import CheckReport

logger = logging.getLogger("amble")

FINEST = 4
"""Intervals of the finest mesh that is tried, for each one of the first."""

NEAR_RECORD = 0.5 * RECORD
"""How far a closed loop's own orbit may be from the record: half of what a certificate allows that of the stabilised
one, which lies elsewhere."""

SHIPPED = "astro-amble.toml"
"""The paper's amble."""


class GaitNotCheckedError(WorkError):
    """The solver found a gait, which fails its check on every mesh that was tried; the message says what to change.

    Attributes:
        last: the gait, on the first mesh.
        report: of its check; None where it could not be computed.
    """

    def __init__(self, found: Checked, intervals: int) -> None:
        self.last, self.report = found.gait, found.report
        super().__init__(
            f"a gait was found, but it fails its check on {intervals} to {FINEST * intervals} intervals a domain: "
            f"{_what_fails(found)}; start with more intervals ([solver] intervals), keep a margin of the limits at the "
            "nodes ([limits] node_margins = true), or widen the limit that is missed"
        )


@dataclass(frozen=True, kw_only=True)
class Checked:
    """A gait and what its check found.

    Attributes:
        gait: the gait, on the first mesh that passes its check; on the first of all where none does.
        report: of that gait's check; None where it could not be computed.
        factor: how many intervals the mesh has for each one of the first.
    """

    gait: Gait
    report: CheckReport | None
    factor: int

    @property
    def passed(self) -> bool:
        """Whether every row of the check holds."""
        return self.report is not None and self.report.passed


def until_checked(
    problem: GaitProblem,
    gait: Gait,
    tolerance: float = 1e-8,
    most_iterations: int = 500,
    *,
    progress: Progress | None = None,
    solver: str = "ipopt",
) -> Checked:
    """Check a gait, and where that fails again on meshes of twice and four times the intervals; says what it did.

    On a finer mesh the motion is kept first (``refine``), which mends what the mesh has wrong. Where a limit is still
    missed between the nodes, the problem is solved again from there.

    A gait that passes goes onto a finer mesh as well where its closed loop's own orbit is further from what is recorded
    than a certificate allows (``missed_orbit``), as the error of the mesh is magnified; it keeps the last that passes.

    Args:
        problem: the problem that the gait solves.
        gait: the gait.
        tolerance: of the solver, where a finer problem is solved.
        most_iterations: of the solver.
        progress: called while it works.
        solver: name of a registered solver, as in ``synthesize``.
    """
    problem = replace(problem, outputs=gait.outputs)  # others than the problem's where those were singular
    found = first = _checked(gait, 1, progress)

    def finer(known: Checked) -> Checked | None:
        factor = 2 * known.factor
        try:
            found = _checked(refine(problem, known.gait, 2, progress), factor, progress)
            if found.passed:
                return found
            denser = replace(problem, intervals=factor * problem.intervals)
            again = synthesize(denser, found.gait, tolerance, most_iterations, progress, solver=solver)
            return _checked(again, factor, progress)
        except WorkError as error:
            logger.warning("no gait was found on %d times the intervals: %s", factor, str(error).splitlines()[0])
            return None

    while not found.passed and found.factor < FINEST:
        following = finer(found)
        if following is None:
            break
        found = following
    if not found.passed:
        logger.warning("the gait does not pass its check: %s", _what_fails(first))
        return first
    why = "until the gait passed its check"
    while found.factor < FINEST and missed_orbit(found.gait, progress) > NEAR_RECORD:
        following = finer(found)
        if following is None or not following.passed:
            break
        found, why = following, "until the closed loop's own orbit was the gait's"
    if found is not first:
        intervals = found.factor * problem.intervals
        logger.warning("the mesh was made finer, to %d intervals a domain, %s", intervals, why)
    return found


def missed_orbit(gait: Gait, progress: Progress | None = None) -> float:
    """Return how far the entry of a gait's closed loop on its own orbit is from the recorded one; lengths in l, times.

    As a certificate measures it (``stability.orbit_conditions``), under the outputs of the gait problem; 0 where there
    is no such orbit, which no finer mesh would mend.

    Args:
        gait: the gait.
        progress: called after every Newton step.
    """
    try:
        state = bare_fixed_point(gait, progress)[1].state
    except WorkError:
        return 0.0
    return max(abs(row.value) for row in entry_rows(replace(gait, feedback=None), state))


def _checked(gait: Gait, factor: int, progress: Progress | None) -> Checked:
    try:
        report = check(gait, progress=progress)
    except WorkError as error:
        logger.warning("the gait cannot be checked: %s", str(error).splitlines()[0])
        return Checked(gait=gait, report=None, factor=factor)
    return Checked(gait=gait, report=report, factor=factor)


def _what_fails(found: Checked) -> str:
    if found.report is None:
        return "its closed loop cannot be computed"
    worst = worst_first(found.report.failed)[0]
    return f"{len(found.report.failed)} of {len(found.report.rows)} rows fail, the worst is {worst}"


@dataclass(frozen=True)
class PosedProblem:
    """A specification that was read, once: what it is called, its gait problem and its solver settings."""

    name: str
    problem: GaitProblem
    solver: SolverSection


def pose(specification: Specification | str | Path | None) -> PosedProblem:
    """Read a specification and build its problem; where none is given, the paper's amble that ships with the package.

    Paths inside a specification start from its file's folder, or from the working folder where it is no file.

    Raises:
        InputError, UnknownNameError: the specification cannot be used.
    """
    if isinstance(specification, Specification):
        return PosedProblem("given from Python", problem_of(specification), specification.solver)
    if specification is None:
        with resources.as_file(resources.files("amble.specifications") / SHIPPED) as shipped:
            return pose(shipped)
    path = Path(specification)
    read = read_specification(path)
    return PosedProblem(path.name, problem_of(read, path.parent), read.solver)


def solve(posed: PosedProblem, start: Gait | None = None, *, progress: Progress | None = None) -> Gait:
    """Find the gait of a posed problem; errors as in ``synthesize_specification``."""
    solver = posed.solver
    gait = synthesize(posed.problem, start, solver.tolerance, solver.iterations, progress, solver=solver.name)
    if solver.refinement is None:
        found = until_checked(
            posed.problem, gait, solver.tolerance, solver.iterations, progress=progress, solver=solver.name
        )
        if not found.passed:
            raise GaitNotCheckedError(found, posed.problem.intervals)
        return found.gait
    problem = replace(posed.problem, outputs=gait.outputs)
    return gait if solver.refinement == 1 else refine(problem, gait, solver.refinement, progress)


def synthesize_specification(
    specification: Specification | str | Path | None = None,
    start: Gait | str | Path | None = None,
    *,
    progress: Progress | None = None,
) -> Gait:
    """Find the gait that a specification describes, with the solver settings that it holds.

    Args:
        specification: a file, or what ``amble.read_specification`` returned; by default the paper's amble.
        start: a gait or its file to start from, with its multipliers; by default a kinematic walk.
        progress: called after every iteration.

    Raises:
        InputError, UnknownNameError: the specification or the start cannot be used.
        GaitNotSolvedError: the solver stopped without a solution; the error carries the last iterate.
        GaitNotCheckedError: what it found fails its check on every mesh; the error carries the gait.
        NotSolvedError: equality rows depend on each other, or the finer mesh does not converge.
    """
    posed = pose(specification)
    known = start if start is None or isinstance(start, Gait) else load_gait(start, posed.problem.pattern.robot)
    return solve(posed, known, progress=progress)
