"""``amble compare``: allocation laws along the same motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli import laws
from amble.cli.output import result, show, wrote
from amble.cli.progress import progress


def compare(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    trace: Annotated[
        Path | None, typer.Option(help="Trace of its simulation, to compare along that too.", show_default=False)
    ] = None,
    law: Annotated[list[str] | None, typer.Option(help=laws.HELP, show_default="every law that applies")] = None,
    out: Annotated[Path | None, typer.Option(help="Where to write the numbers (JSON).", show_default=False)] = None,
    figure: Annotated[
        Path | None, typer.Option(help="Where to draw the torques of one cycle, without suffix.", show_default=False)
    ] = None,
) -> None:
    """Tabulate cost, torques, friction and active limits of allocation laws along the same motion."""
    from amble.analysis import LawChoice, compare_allocations, every_law, samples_of_trace
    from amble.analysis.laws import labelled
    from amble.gait.files import load_gait
    from amble.report import write_results
    from amble.report.allocation import allocation_figure, allocation_results, allocation_table
    from amble.report.figures import require_matplotlib, save
    from amble.simulation import load_trace

    if figure is not None:
        require_matplotlib()
    walker = load_gait(gait)
    asked = [laws.parse_law(word, walker.pattern) for word in law or ()]
    chosen = LawChoice(labelled(asked), {}) if asked else every_law(walker)
    motions = [None] if trace is None else [None, samples_of_trace(load_trace(trace), walker.pattern)]
    with progress("comparing"):
        found = [compare_allocations(walker, chosen.laws, samples) for samples in motions]
    for metrics in found:
        show(allocation_table(metrics, chosen.notes).text())
    numbers = allocation_results([entry for metrics in found for entry in metrics])
    result(allocation=numbers, omitted=dict(chosen.omitted))
    if out is not None:
        wrote(write_results(out, {"allocation": numbers}))
    if figure is not None:
        for path in save(allocation_figure(walker, chosen.laws), figure):
            wrote(path)
