"""``amble synthesize``: from a specification to a gait."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.lines import tell_synthesized
from amble.cli.output import wrote
from amble.cli.progress import progress


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
    from amble.gait.files import load_gait, save_gait
    from amble.synthesis.synthesize import GaitNotSolvedError
    from amble.workflow.specified import pose, solve

    posed = pose(spec)
    known = None if start is None else load_gait(start, posed.problem.pattern.robot)
    try:
        with progress("optimising the gait") as tell:
            gait = solve(posed, known, progress=tell)
    except GaitNotSolvedError as error:
        if keep is not None:
            wrote(save_gait(error.last, keep))
        raise
    tell_synthesized(gait)
    wrote(save_gait(gait, out))
