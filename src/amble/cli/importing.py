"""``amble import``: a motion of npz, CSV or MATLAB as a gait."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.lines import show_synthesized
from amble.cli.output import wrote


def importing(
    motion: Annotated[Path, typer.Argument(help="Motion: a file .npz, .csv or .mat.", show_default=False)],
    spec: Annotated[
        Path | None,
        typer.Option(
            help="Specification of its robot and gait; needed where amble did not write the file.", show_default=False
        ),
    ] = None,
    coordinates: Annotated[
        str | None,
        typer.Option(
            help="Names of the file's columns, with commas, - before one of opposite sign.",
            show_default="as in the file, else the robot's order",
        ),
    ] = None,
    out: Annotated[Path, typer.Option(help="Where to write the gait.")] = Path("gait.json"),
) -> None:
    """Read a motion as a gait, to be checked, stabilised, compared, or started from; nothing is optimised."""
    from amble.gait.files import save_gait
    from amble.gait.motion_files import read_motion, recorded_gait
    from amble.synthesis.imported import imported_gait
    from amble.workflow.specified import pose

    recorded = read_motion(motion)
    if spec is None:
        found = recorded_gait(recorded)
    else:
        names = None if coordinates is None else [name.strip() for name in coordinates.split(",")]
        found = imported_gait(pose(spec).problem, recorded, names)
    show_synthesized(found)
    wrote(save_gait(found, out))
