"""``amble robustness``: gains from the linearisation, reaches of errors, and trials of pushes in several engines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from amble.cli import options
from amble.cli.console import progress
from amble.cli.output import result, show, wrote


def robustness(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    engine: Annotated[
        list[str] | None,
        typer.Option(help="Engine of the trials: native, mujoco; may be repeated.", show_default="native"),
    ] = None,
    control: Annotated[str | None, typer.Option(help=options.CONTROL_HELP, show_default="the gait's own")] = None,
    trials: Annotated[int, typer.Option(min=1, help="Pushed walks in each engine.")] = 1000,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the pushes.")] = 1,
    cycles: Annotated[int, typer.Option(min=2, help="Gait cycles of a walk, pushed in the first.")] = 8,
    friction: Annotated[float, typer.Option(help="Friction of the ground that is walked on.")] = 0.8,
    largest: Annotated[float, typer.Option(help="Impulse of the largest push, in m sqrt(g l).")] = 1.0,
    workers: Annotated[int, typer.Option(min=1, help="Processes that do the trials.")] = 2,
    out: Annotated[Path, typer.Option(help="Folder of the results and of the trials that are done.")] = Path(
        "robustness"
    ),
) -> None:
    """Say how far pushes and errors of the plant can go, predicted and measured.

    Trials that a run has finished are kept in the folder, and a run that was interrupted goes on from them.
    """
    from amble.gait.files import load_gait
    from amble.report.figures import require_matplotlib
    from amble.report.robustness import (
        correlation_table,
        fast_table,
        outcome_table,
        push_table,
        robustness_table,
        write_robustness,
    )
    from amble.stability.robustness import TrialSettings
    from amble.workflow.robustness import robustness as measured

    require_matplotlib()
    settings = TrialSettings(seed=seed, cycles=cycles, friction=friction, largest=largest)
    walker = options.under(load_gait(gait), control)
    with progress("robustness") as notify:
        found = measured(walker, out, engine or ["native"], trials, settings, workers, notify)
    for table in (robustness_table, push_table, outcome_table, correlation_table, fast_table):
        show(table(found).text())
    result(robustness=found.to_dict())
    for path in write_robustness(out, found):
        wrote(path)
