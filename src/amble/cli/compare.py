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
    from amble.analysis import LawChoice, compare_laws, every_law, labelled
    from amble.gait.files import load_gait
    from amble.report import write_results
    from amble.report.allocation import allocation_figure, allocation_results, law_table
    from amble.report.figures import require_matplotlib, save
    from amble.simulation import load_trace

    if figure is not None:
        require_matplotlib()
    walker = load_gait(gait)
    asked = [laws.parse_law(word, walker.pattern) for word in law or ()]
    chosen = LawChoice(labelled(asked), {}) if asked else every_law(walker)
    simulated = None if trace is None else load_trace(trace)
    with progress("comparing"):
        found = compare_laws(walker, chosen.laws, simulated)
    for motion in dict.fromkeys(entry.motion for entry in found.metrics):
        show(law_table(found, motion, notes=chosen.notes).text())
    numbers = allocation_results(found)
    result(allocation=numbers, omitted=dict(chosen.omitted))
    if out is not None:
        wrote(write_results(out, {"allocation": numbers}))
    if figure is not None:
        for path in save(allocation_figure(walker, chosen.laws), figure):
            wrote(path)
