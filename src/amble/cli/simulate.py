"""``amble simulate``: the closed loop of a gait, cycle after cycle."""

from __future__ import annotations

from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli import laws
from amble.cli.console import wrote
from amble.cli.progress import progress
from amble.errors import FallError

if TYPE_CHECKING:
    from amble.control.allocation import AllocationLaw
    from amble.gait import Gait
    from amble.simulation import Trace


class Controller(StrEnum):
    """What computes the torques of a simulation."""

    MODEL = "model"
    C = "c"


def simulate(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    cycles: Annotated[int, typer.Option(min=1, help="Gait cycles to walk.")] = 20,
    tolerance: Annotated[float, typer.Option(help="Relative and absolute tolerance of the integrator.")] = 1e-8,
    law: Annotated[str | None, typer.Option(help=laws.HELP, show_default="the gait's own")] = None,
    perturb: Annotated[float, typer.Option(min=0.0, help="Change of every start state, up or down at random.")] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of the change.")] = 0,
    controller: Annotated[
        Controller, typer.Option(help="What computes the torques: the model, or the exported C code.")
    ] = Controller.MODEL,
    out: Annotated[Path, typer.Option(help="Where to write the trace (netCDF).")] = Path("trace.nc"),
) -> None:
    """Simulate the closed loop of a gait; exits 1 where it falls, with the trace up to there."""
    from amble.gait.closed_loop import trace_units
    from amble.gait.files import load_gait
    from amble.report import contact_rows, contact_summary
    from amble.report.assembly import monitors
    from amble.simulation import save_trace

    walker = load_gait(gait)
    chosen = None if law is None else laws.parse_law(law, walker.pattern)
    trace = walk(walker, cycles, tolerance, chosen, perturb, seed, controller)
    wrote(save_trace(trace, out, trace_units(walker)))
    report = monitors(walker, trace)
    typer.echo(contact_summary(report).text())
    if report.violations:
        typer.echo(contact_rows(report, only_violations=True).text())
    if not trace.completed:
        raise FallError(trace.ended)


def walk(
    gait: Gait,
    cycles: int,
    tolerance: float,
    law: AllocationLaw | None = None,
    perturb: float = 0.0,
    seed: int = 0,
    controller: Controller = Controller.MODEL,
) -> Trace:
    """Walk a gait with progress, and say how it went."""
    from amble.export import exported_loop
    from amble.simulation import simulate_gait

    loop = exported_loop if controller is Controller.C else None
    with progress("simulating") as update:
        trace = simulate_gait(
            gait, cycles, law, tolerance, perturb, seed, lambda done, of: update(f"cycle {done} of {of}"), loop
        )
    typer.echo(f"{trace.cycles} cycles, {trace.time[-1]:.3f} s of walking, simulated in {trace.seconds:.2f} s")
    return trace
