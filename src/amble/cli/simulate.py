"""``amble simulate``: the closed loop of a gait, cycle after cycle."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import Annotated

import typer

from amble.cli import laws
from amble.cli.lines import tell_simulated
from amble.cli.output import result, show, wrote
from amble.cli.progress import progress
from amble.defaults import CYCLES, ENGINE, TOLERANCE
from amble.errors import FallError


class Controller(StrEnum):
    """What computes the torques of a simulation."""

    MODEL = "model"
    C = "c"


def simulate(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    cycles: Annotated[int, typer.Option(min=1, help="Gait cycles to walk.")] = CYCLES,
    tolerance: Annotated[float, typer.Option(help="Relative and absolute tolerance of the integrator.")] = TOLERANCE,
    law: Annotated[str | None, typer.Option(help=laws.HELP, show_default="the gait's own")] = None,
    control: Annotated[
        str | None, typer.Option(help="Feedback law, such as NAME:key=value.", show_default="the gait's own")
    ] = None,
    perturb: Annotated[float, typer.Option(min=0.0, help="Change of every start state, up or down at random.")] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of the change.")] = 0,
    controller: Annotated[
        Controller, typer.Option(help="What computes the torques: the model, or the exported C code.")
    ] = Controller.MODEL,
    engine: Annotated[str, typer.Option(help="What moves the model: native, or one of a plug-in.")] = ENGINE,
    out: Annotated[Path, typer.Option(help="Where to write the trace (netCDF).")] = Path("trace.nc"),
) -> None:
    """Simulate the closed loop of a gait; exits 1 where it falls, with the trace up to there."""
    from amble.analysis import monitors
    from amble.export import exported_loop
    from amble.gait.closed_loop import trace_units
    from amble.gait.files import load_gait
    from amble.report import contact_results, contact_rows, contact_summary
    from amble.simulation import save_trace
    from amble.simulation import simulate as walk

    walker = load_gait(gait)
    chosen = None if law is None else laws.parse_law(law, walker.pattern)
    loop = exported_loop if controller is Controller.C else None
    with progress("simulating") as tell:
        trace = walk(
            walker,
            cycles=cycles,
            tolerance=tolerance,
            perturbation=perturb,
            seed=seed,
            engine=engine,
            law=chosen,
            control=None if control is None else laws.parse_control(control),
            loop=loop,
            progress=tell,
        )
    tell_simulated(trace)
    wrote(save_trace(trace, out, trace_units(walker)))
    report = monitors(walker, trace)
    show(contact_summary(report).text())
    if report.violations:
        show(contact_rows(report, only_violations=True).text())
    result(contact=contact_results(report))
    if not trace.completed:
        raise FallError(trace.ended)
