"""``amble init``: a whole specification of a robot's gait, to read and to change."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli import naming
from amble.cli.output import show, wrote


def init(
    robot: Annotated[str, typer.Argument(help="Robot: a URDF file or a name of the catalogue.", show_default=False)],
    gait: Annotated[str | None, naming.GAIT] = None,
    speed: Annotated[str | None, naming.SPEED] = None,
    feet: Annotated[str | None, naming.FEET] = None,
    symmetrize: Annotated[bool | None, naming.SYMMETRIZE] = None,
    out: Annotated[Path, typer.Option(help="Where to write the specification.")] = Path("spec.toml"),
) -> None:
    """Write the specification of a robot's gait with every default filled in, for `amble synthesize`.

    Feet that are not named are proposed by their position, and written into the file.
    """
    from amble.io.storage import atomic_write
    from amble.synthesis.specified import problem_of
    from amble.workflow.proposal import written

    asked = naming.specification(robot, feet, gait, speed, symmetrize, propose=True)
    problem = problem_of(asked)
    if feet is None and asked.robot.feet:
        listing = ", ".join(f"{label} = {frame}" for label, frame in asked.robot.feet.items())
        show(f"feet by position, to be confirmed: {listing}")
    atomic_write(out, written(asked, problem, out.parent))
    wrote(out)
