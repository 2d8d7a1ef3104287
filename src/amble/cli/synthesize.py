"""``amble synthesize``: from a specification to a gait."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli.console import wrote
from amble.cli.progress import Update, progress

if TYPE_CHECKING:
    from amble.gait import Gait, SolverReport
    from amble.synthesis import Iteration


def synthesize(
    spec: Annotated[Path, typer.Argument(help="Specification, a TOML file.", show_default=False)],
    out: Annotated[Path, typer.Option(help="Where to write the gait.")] = Path("gait.json"),
    start: Annotated[
        Path | None,
        typer.Option(
            "--from", help="Gait to start from, with its multipliers; else a kinematic walk.", show_default=False
        ),
    ] = None,
    keep: Annotated[
        Path | None, typer.Option(help="Where to write the last iterate of a failed run.", show_default=False)
    ] = None,
) -> None:
    """Find the gait that a specification describes."""
    from amble.gait.files import save_gait
    from amble.synthesis.synthesize import GaitNotSolvedError

    try:
        wrote(save_gait(synthesized(spec, start), out))
    except GaitNotSolvedError as error:
        if keep is not None:
            wrote(save_gait(error.last, keep))
        raise


def synthesized(spec: Path, start: Path | None = None) -> Gait:
    """Solve the problem of a specification with progress, and say how it went."""
    from amble.gait.files import load_gait
    from amble.synthesis import refine
    from amble.synthesis import synthesize as find
    from amble.synthesis.specification import read_specification
    from amble.synthesis.specified import problem_of

    specification = read_specification(spec)
    solver = specification.solver
    problem = problem_of(specification, spec.parent)
    known = load_gait(start, problem.pattern.robot) if start is not None else None
    with progress("optimising the gait") as update:
        gait = find(problem, known, solver.tolerance, solver.iterations, lambda iteration: _show(update, iteration))
    typer.echo(solved_line(gait.solver))
    return gait if solver.refinement == 1 else refine(problem, gait, solver.refinement)


def solved_line(report: SolverReport) -> str:
    """One line about a solver's run."""
    return (
        f"{report.solver}: {report.status}, {report.iterations} iterations in {report.seconds:.2f} s "
        f"({report.variables} variables, {report.constraints} constraints), objective {report.objective:.6g} N^2 m^2"
    )


def _show(update: Update, iteration: Iteration) -> None:
    update(
        f"iteration {iteration.number}, objective {iteration.objective:.5g}, "
        f"worst row '{iteration.worst_row}' violated by {iteration.violation:.2g}"
    )
