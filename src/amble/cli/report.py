"""``amble report``: tables, figures and page of a folder that holds a gait and its trace."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.console import wrote
from amble.cli.progress import progress

GAIT, TRACE, RESULTS = "gait.json", "trace.nc", "results.json"


def report(
    folder: Annotated[Path, typer.Argument(help=f"Folder with {GAIT} and {TRACE}.", show_default=False)],
    out: Annotated[Path | None, typer.Option(help="Where to write.", show_default="the same folder")] = None,
) -> None:
    """Write results.json, report.md and the figures anew; what an earlier results.json says of stability is kept."""
    from amble.gait.files import load_gait
    from amble.report.assembly import assemble
    from amble.report.figures import require_matplotlib
    from amble.report.results import read_results, seconds_from, settings_from
    from amble.report.run import main_table, write_run
    from amble.report.stability_results import stability_from
    from amble.simulation import load_trace

    require_matplotlib()
    earlier = read_results(folder / RESULTS)
    settings, seconds, known = settings_from(earlier), seconds_from(earlier), stability_from(earlier)
    gait, trace = load_gait(folder / GAIT), load_trace(folder / TRACE)
    settings = settings or {"tolerance of the simulation": f"{trace.tolerance:g}"}
    seconds = seconds or {"simulation": trace.seconds}
    with progress("measuring"):
        run = assemble(gait, trace, settings, seconds, known)
    with progress("drawing"):
        written = write_run(out or folder, run)
    for path in written:
        wrote(path)
    typer.echo(main_table(run).text())
