"""``amble compare``: allocation laws along the same motion."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli import laws
from amble.cli.console import wrote


def compare(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    trace: Annotated[
        Path | None, typer.Option(help="Trace of its simulation, to compare along that too.", show_default=False)
    ] = None,
    law: Annotated[list[str] | None, typer.Option(help=laws.HELP, show_default="drop, pinv")] = None,
    out: Annotated[Path | None, typer.Option(help="Where to write the numbers (JSON).", show_default=False)] = None,
) -> None:
    """Tabulate cost of transport, peak and RMS torque of several laws along the same motion."""
    from amble.control.actuator import ACTUATORS
    from amble.gait.files import load_gait
    from amble.report import law_table, method_results, write_results
    from amble.report.assembly import compare_laws, paper_laws
    from amble.simulation import load_trace

    walker = load_gait(gait)
    chosen = [laws.parse_law(word, walker.pattern) for word in law] if law else paper_laws(walker)
    comparison = compare_laws(walker, chosen, None if trace is None else load_trace(trace))
    models = [model.name for model in ACTUATORS]
    for motion in ("nominal",) if trace is None else ("nominal", "simulated"):
        typer.echo(law_table(comparison, motion, models).text())
    if out is not None:
        wrote(write_results(out, {model: method_results(comparison, model) for model in models}))
