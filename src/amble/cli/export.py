"""``amble export``: the controller of a gait as self-contained C99."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli import laws
from amble.cli.output import result, wrote
from amble.cli.progress import progress


def export(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    law: Annotated[str | None, typer.Option(help=laws.HELP, show_default="the gait's own")] = None,
    out: Annotated[Path, typer.Option("--out", "-o", help="Folder of the C files.")] = Path("controller"),
) -> None:
    """Write the controller as C: no heap, one header, a step function, test vectors and a program to replay them."""
    from amble.export import export_controller
    from amble.gait.files import load_gait

    walker = load_gait(gait)
    chosen = None if law is None else laws.parse_law(law, walker.pattern)
    with progress("exporting"):
        exported = export_controller(walker, chosen, out)
    for path in exported.files:
        wrote(path)
    result(law=(chosen or walker.law).name)
