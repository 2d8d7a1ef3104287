"""``amble synthesize``: from a specification, or from a robot, a gait and a speed, to a gait."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli import naming
from amble.cli.lines import tell_synthesized
from amble.cli.output import wrote
from amble.cli.progress import progress
from amble.errors import InputError, shown


def synthesize(
    spec: Annotated[
        str,
        typer.Argument(
            help="Specification, a TOML file; or a robot (URDF file, name of the catalogue) with --gait and --speed.",
            show_default=False,
        ),
    ],
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
    feet: Annotated[str | None, naming.FEET] = None,
    gait: Annotated[str | None, naming.GAIT] = None,
    speed: Annotated[str | None, naming.SPEED] = None,
    symmetrize: Annotated[bool | None, naming.SYMMETRIZE] = None,
) -> None:
    """Find the gait that a specification describes, or that of a robot by default."""
    from amble.gait.files import load_gait, save_gait
    from amble.synthesis.synthesize import GaitNotSolvedError
    from amble.workflow.specified import pose, solve

    if naming.is_robot(spec):
        posed = pose(naming.specification(spec, feet, gait, speed, symmetrize, propose=False))
    elif any(option is not None for option in (feet, gait, speed, symmetrize)):
        raise InputError(
            f"'{shown(spec)}' is a specification, which holds feet, gait and speed itself; --feet, --gait, --speed and "
            "--symmetrize belong to a robot (URDF file or name of the catalogue)"
        )
    else:
        posed = pose(Path(spec))
    known = None if start is None else load_gait(start, posed.problem.pattern.robot)
    try:
        with progress("optimising the gait") as tell:
            found = solve(posed, known, progress=tell)
    except GaitNotSolvedError as error:
        if keep is not None:
            wrote(save_gait(error.last, keep))
        raise
    tell_synthesized(found)
    wrote(save_gait(found, out))
