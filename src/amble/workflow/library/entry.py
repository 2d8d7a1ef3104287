"""One gait of a library: solved from its neighbour, checked, stabilised from its neighbour's weights, certified."""

from __future__ import annotations

import logging
import time
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field

from amble.errors import AmbleError, InputError, NotSolvedError
from amble.gait import Gait
from amble.gait.unfolding import unfolded
from amble.progress import Progress, ProgressReport, silent
from amble.stability import Certificate, certify
from amble.stability.stabilize import stabilization
from amble.synthesis.possible import require_possible
from amble.synthesis.program import build_program
from amble.synthesis.sweep import solve_from
from amble.types import Json
from amble.workflow.library.axes import LibrarySpecification
from amble.workflow.library.numbers import certificate_numbers, gait_numbers, stabilisation_numbers
from amble.workflow.specified import GaitNotCheckedError, until_checked

STAGES = ("solve", "check", "stabilise", "certify")
"""What is done with every gait, in order."""


@dataclass(kw_only=True)
class Made:
    """What became of one gait so far.

    Attributes:
        stage: the last that was begun.
        reason: why it failed; empty where it did not.
        gait: as far as it came; None where it was not solved.
        certificate: of the gait; None where it failed before.
        numbers: for the index.
        seconds: stage -> processor time, s.
        notes: warnings on the way.
    """

    stage: str = STAGES[0]
    reason: str = ""
    gait: Gait | None = None
    certificate: Certificate | None = None
    numbers: Json = field(default_factory=dict)
    seconds: dict[str, float] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)


def make_gait(
    library: LibrarySpecification,
    values: Mapping[str, float],
    near: Gait | None,
    stable: Gait | None,
    progress: Progress | None = None,
) -> Made:
    """Find, check, stabilise and certify one gait; what fails is said in the result, and nothing of amble's is raised.

    Args:
        library: what is to be found.
        values: axis -> its value.
        near: a neighbour's gait, from which the solver starts; None begins with a kinematic walk.
        stable: a stabilised neighbour, whose weights are the first that are tried.
        progress: called while it works.
    """
    made = Made()
    with _warnings(made.notes):
        try:
            _solve(made, library, values, near, progress or silent)
            _stabilise(made, stable, progress or silent)
            _certify(made, progress or silent)
        except AmbleError as error:
            made.reason = str(error)
    return made


def _solve(
    made: Made, library: LibrarySpecification, values: Mapping[str, float], near: Gait | None, progress: Progress
) -> None:
    with _stage(made, "solve", progress):
        specification = library.specification(values)
        problem, solver = library.problem(values), specification.solver
        require_possible(problem)
        fitting = _alike(near, problem.pattern.mirrored)
        program = build_program(problem, library.grid.size)
        outcome = solve_from(program, fitting, solver.tolerance, solver.iterations, progress, solver=solver.name)
        made.numbers |= {"from_neighbour": outcome.warm, "all_iterations": outcome.iterations}
        if outcome.gait is None:
            raise NotSolvedError(outcome.status)
        made.gait = outcome.gait
    with _stage(made, "check", progress):
        found = until_checked(
            problem, made.gait, solver.tolerance, solver.iterations, progress=progress, solver=solver.name
        )
        made.gait = found.gait
        made.numbers |= gait_numbers(found.gait)
        if not found.passed:
            raise GaitNotCheckedError(found, problem.intervals)


def _alike(near: Gait | None, mirrored: bool) -> Gait | None:
    """Return a neighbour with a problem's stances: a named gait is mirrored straight ahead, and not where it turns."""
    if near is None or near.pattern.mirrored == mirrored:
        return near
    try:
        return None if mirrored else unfolded(near)
    except InputError:  # without its mirror it has no known form
        return None


def _stabilise(made: Made, stable: Gait | None, progress: Progress) -> None:
    gait = _gait(made)
    with _stage(made, "stabilise", progress):
        found = stabilization(gait, progress=progress, near=_alike(stable, gait.pattern.mirrored))
        made.gait = found.gait
        made.numbers |= stabilisation_numbers(found)


def _certify(made: Made, progress: Progress) -> None:
    gait = _gait(made)
    with _stage(made, "certify", progress):
        made.certificate = certify(gait, progress=progress)
        made.numbers |= certificate_numbers(made.certificate)


def _gait(made: Made) -> Gait:
    if made.gait is None:
        raise NotSolvedError(made.reason)
    return made.gait


@contextmanager
def _stage(made: Made, name: str, progress: Progress) -> Iterator[None]:
    """Count the processor time of a stage, also where it fails."""
    made.stage = name
    progress(ProgressReport(what=name))
    began = time.process_time()
    try:
        yield
    finally:
        made.seconds[name] = time.process_time() - began


class _Collector(logging.Handler):
    """Keeps what is warned of."""

    def __init__(self, notes: list[str]) -> None:
        super().__init__(logging.WARNING)
        self._notes = notes

    def emit(self, record: logging.LogRecord) -> None:
        """Keep one warning."""
        self._notes.append(record.getMessage())


@contextmanager
def _warnings(notes: list[str]) -> Iterator[None]:
    """Keep the package's warnings while the block lasts, instead of printing them."""
    logger, collector = logging.getLogger("amble"), _Collector(notes)
    handlers, propagates = logger.handlers, logger.propagate
    logger.handlers, logger.propagate = [collector], False
    try:
        yield
    finally:
        logger.handlers, logger.propagate = handlers, propagates
