"""``amble reproduce``: the whole paper, from the robot to the table and the figures."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli.choices import METHOD_OPTION
from amble.cli.lines import tell_certified, tell_simulated, tell_stabilized, tell_synthesized
from amble.cli.output import result, show
from amble.cli.progress import progress
from amble.defaults import METHOD, REPRODUCED_CYCLES, TOLERANCE, Method


def reproduce(
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("runs/astro-amble"),
    cycles: Annotated[int, typer.Option(min=1, help="Gait cycles to simulate.")] = REPRODUCED_CYCLES,
    tolerance: Annotated[float, typer.Option(help="Tolerance of the simulation.")] = TOLERANCE,
    spec: Annotated[Path | None, typer.Option(help="Specification.", show_default="the paper's amble")] = None,
    method: Annotated[Method, METHOD_OPTION] = METHOD,
) -> None:
    """Synthesise, stabilise, certify, simulate, and print the paper's Table 1 beside ours."""
    from amble.report.figures import require_matplotlib
    from amble.report.run import main_table, run_results
    from amble.workflow import reproduce as run_all

    require_matplotlib()
    with progress("reproducing") as tell:
        run = run_all(spec, out, method=method, cycles=cycles, tolerance=tolerance, progress=tell)
    tell_synthesized(run.synthesized)
    tell_stabilized(run.stabilized)
    tell_certified(run.gait, run.certificate)
    tell_simulated(run.trace)
    show(main_table(run.report).text())
    result(results=run_results(run.report))
