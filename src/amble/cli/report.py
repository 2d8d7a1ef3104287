"""``amble report``: tables, figures and page of a folder that holds a gait and its trace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli import laws
from amble.cli.output import result, show
from amble.cli.progress import progress


def report(
    folder: Annotated[Path, typer.Argument(help="Folder with gait.json and trace.nc.", show_default=False)],
    out: Annotated[Path | None, typer.Option(help="Where to write.", show_default="the same folder")] = None,
    law: Annotated[list[str] | None, typer.Option(help=laws.HELP, show_default="every law that applies")] = None,
) -> None:
    """Write results.json, both reports and the figures anew; what an earlier results.json says of stability is kept."""
    from amble.report.figures import require_matplotlib
    from amble.report.run import main_table, run_results
    from amble.workflow import rewrite_report

    require_matplotlib()
    with progress("reporting") as tell:
        written = rewrite_report(
            folder, out, lambda pattern: [laws.parse_law(word, pattern) for word in law or ()], progress=tell
        )
    show(main_table(written).text())
    result(results=run_results(written))
