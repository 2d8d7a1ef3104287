"""``amble stabilize``: output weights that make a gait's orbit attractive."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.choices import METHOD_OPTION
from amble.cli.lines import tell_stabilized
from amble.cli.output import wrote
from amble.cli.progress import progress
from amble.defaults import FREE, METHOD, Method


def stabilize(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    free: Annotated[
        list[str] | None, typer.Option(help="Coordinate with free weights.", show_default=", ".join(FREE))
    ] = None,
    method: Annotated[Method, METHOD_OPTION] = METHOD,
    out: Annotated[Path, typer.Option(help="Where to write the stabilised gait.")] = Path("gait.json"),
) -> None:
    """Weight the outputs of a gait until its orbit is exponentially stable."""
    from amble.gait.files import load_gait, save_gait
    from amble.stability.stabilize import stabilization

    walker = load_gait(gait)
    with progress("stabilising") as tell:
        found = stabilization(walker, tuple(free or FREE), method, tell)
    tell_stabilized(found)
    wrote(save_gait(found.gait, out))
