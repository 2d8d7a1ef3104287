"""From a specification to a gait: read once, solved, and refined where it asks for that."""

from __future__ import annotations

from dataclasses import dataclass
from importlib import resources
from pathlib import Path

from amble.gait import Gait
from amble.gait.files import load_gait
from amble.progress import Progress
from amble.synthesis.problem import GaitProblem
from amble.synthesis.refine import refine
from amble.synthesis.specification import SolverSection, Specification, read_specification
from amble.synthesis.specified import problem_of
from amble.synthesis.synthesize import synthesize
from amble.workflow.checked import until_checked

SHIPPED = "astro-amble.toml"
"""The paper's amble."""


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
        return until_checked(
            posed.problem, gait, solver.tolerance, solver.iterations, progress=progress, solver=solver.name
        ).gait
    return gait if solver.refinement == 1 else refine(posed.problem, gait, solver.refinement, progress)


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
        NotSolvedError: equality rows depend on each other, or the finer mesh does not converge.
    """
    posed = pose(specification)
    known = start if start is None or isinstance(start, Gait) else load_gait(start, posed.problem.pattern.robot)
    return solve(posed, known, progress=progress)
