"""Solved means checked: a mesh is made finer until a gait passes its check, or what fails is said."""

from __future__ import annotations

import logging
from dataclasses import dataclass, replace

from amble.errors import WorkError
from amble.gait import Gait
from amble.progress import Progress
from amble.residual import worst_first
from amble.synthesis.problem import GaitProblem
from amble.synthesis.refine import refine
from amble.synthesis.synthesize import synthesize
from amble.verification.check import check
from amble.verification.findings import CheckReport

logger = logging.getLogger("amble")

FINEST = 4
"""Intervals of the finest mesh that is tried, for each one of the first."""


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

    Args:
        problem: the problem that the gait solves.
        gait: the gait.
        tolerance: of the solver, where a finer problem is solved.
        most_iterations: of the solver.
        progress: called while it works.
        solver: name of a registered solver, as in ``synthesize``.
    """
    found = first = _checked(gait, 1, progress)
    while not found.passed and found.factor < FINEST:
        factor = 2 * found.factor
        try:
            found = _checked(refine(problem, found.gait, 2, progress), factor, progress)
            if not found.passed:
                finer = replace(problem, intervals=factor * problem.intervals)
                again = synthesize(finer, found.gait, tolerance, most_iterations, progress, solver=solver)
                found = _checked(again, factor, progress)
        except WorkError as error:
            logger.warning("no gait was found on %d times the intervals: %s", factor, str(error).splitlines()[0])
            break
    if not found.passed:
        logger.warning("the gait does not pass its check: %s", _what_fails(first))
        return first
    if found is not first:
        intervals = found.factor * problem.intervals
        logger.warning("the mesh was made finer, to %d intervals a domain, until the gait passed its check", intervals)
    return found


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
