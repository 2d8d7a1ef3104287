"""The whole paper: ``amble reproduce`` from the robot to the table and the figures, ``report`` these anew."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli import options
from amble.cli.console import progress
from amble.cli.lines import show_certified, show_simulated, show_stabilized, show_synthesized
from amble.cli.output import result, show
from amble.defaults import METHOD, REPRODUCED_CYCLES, TOLERANCE, Method


def reproduce(
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("runs/astro-amble"),
    cycles: Annotated[int, typer.Option(min=1, help="Gait cycles to simulate.")] = REPRODUCED_CYCLES,
    tolerance: Annotated[float, typer.Option(help="Tolerance of the simulation.")] = TOLERANCE,
    spec: Annotated[Path | None, typer.Option(help="Specification.", show_default="the paper's amble")] = None,
    method: Annotated[Method, options.METHOD_OPTION] = METHOD,
) -> None:
    """Synthesise, stabilise, certify, simulate, and print the paper's Table 1 beside ours."""
    from amble.report.figures import require_matplotlib
    from amble.report.run import main_table, run_results
    from amble.workflow import reproduce as run_all

    require_matplotlib()
    with progress("reproducing") as notify:
        run = run_all(spec, out, method=method, cycles=cycles, tolerance=tolerance, progress=notify)
    show_synthesized(run.synthesized)
    show_stabilized(run.stabilized)
    show_certified(run.gait, run.certificate)
    show_simulated(run.trace)
    show(main_table(run.report).text())
    result(results=run_results(run.report))


def report(
    folder: Annotated[Path, typer.Argument(help="Folder with gait.json and trace.nc.", show_default=False)],
    out: Annotated[Path | None, typer.Option(help="Where to write.", show_default="the same folder")] = None,
    law: Annotated[list[str] | None, typer.Option(help=options.LAW_HELP, show_default="every law that applies")] = None,
) -> None:
    """Write results.json, both reports and the figures anew; what an earlier results.json says of stability is kept.

    A proof.json of the gait in the folder is shown beside its certificate.
    """
    from amble.report.figures import require_matplotlib
    from amble.report.run import main_table, run_results
    from amble.workflow import rewrite_report

    require_matplotlib()
    with progress("reporting") as notify:
        written = rewrite_report(
            folder, out, lambda pattern: [options.parse_law(word, pattern) for word in law or ()], progress=notify
        )
    show(main_table(written).text())
    result(results=run_results(written))
