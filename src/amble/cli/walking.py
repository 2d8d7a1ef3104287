"""Commands that run a gait: ``amble simulate``, ``compare`` under other laws, ``export`` its controller as C99."""

from __future__ import annotations

import os
from enum import StrEnum
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli import options
from amble.cli.console import progress
from amble.cli.lines import show_simulated, show_switches
from amble.cli.output import result, show, wrote
from amble.defaults import CYCLES, ENGINE, TOLERANCE, Order
from amble.errors import FallError, InputError

if TYPE_CHECKING:
    from amble.gait import Gait
    from amble.simulation import Trace


class Controller(StrEnum):
    """What computes the torques of a simulation."""

    MODEL = "model"
    C = "c"


def simulate(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    cycles: Annotated[int, typer.Option(min=1, help="Gait cycles to walk.")] = CYCLES,
    tolerance: Annotated[float, typer.Option(help="Relative and absolute tolerance of the integrator.")] = TOLERANCE,
    law: Annotated[str | None, typer.Option(help=options.LAW_HELP, show_default="the gait's own")] = None,
    control: Annotated[str | None, typer.Option(help=options.CONTROL_HELP, show_default="the gait's own")] = None,
    perturb: Annotated[float, typer.Option(min=0.0, help="Change of every start state, up or down at random.")] = 0.0,
    seed: Annotated[int, typer.Option(help="Seed of the change.")] = 0,
    controller: Annotated[
        Controller, typer.Option(help="What computes the torques: the model, or the exported C code.")
    ] = Controller.MODEL,
    unilateral: Annotated[
        bool,
        typer.Option(
            "--unilateral",
            help="On ground that pushes only: a foot that pulls is let go, one that leaves its friction cone ends it.",
        ),
    ] = False,
    engine: Annotated[str, typer.Option(help="What moves the model: native, or one of a plug-in.")] = ENGINE,
    out: Annotated[Path, typer.Option(help="Where to write the trace (netCDF).")] = Path("trace.nc"),
) -> None:
    """Simulate the closed loop of a gait; exits 1 where it falls, with the trace up to there."""
    from amble.export import exported_loop
    from amble.gait.closed_loop import trace_units
    from amble.gait.files import load_gait
    from amble.gait.unilateral_state import unilateral_units
    from amble.simulation import save_trace
    from amble.simulation import simulate as walk

    walker = options.under(load_gait(gait), control)
    chosen = None if law is None else options.parse_law(law, walker.pattern)
    loop = exported_loop if controller is Controller.C else None
    with progress("simulating") as notify:
        trace = walk(
            walker,
            cycles=cycles,
            tolerance=tolerance,
            perturbation=perturb,
            seed=seed,
            engine=engine,
            law=chosen,
            loop=loop,
            unilateral=unilateral,
            progress=notify,
        )
    show_simulated(trace)
    wrote(save_trace(trace, out, unilateral_units(walker) if unilateral else trace_units(walker)))
    if unilateral:
        show_switches(trace)
    else:
        _show_monitors(walker, trace)
    if not trace.completed:
        raise FallError(trace.ended)


def _show_monitors(walker: Gait, trace: Trace) -> None:
    from amble.analysis import monitors
    from amble.report import contact_results, contact_rows, contact_summary

    report = monitors(walker, trace)
    show(contact_summary(report).text())
    if report.violations:
        show(contact_rows(report, only_violations=True).text())
    result(contact=contact_results(report))


def compare(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    trace: Annotated[
        Path | None, typer.Option(help="Trace of its simulation, to compare along that too.", show_default=False)
    ] = None,
    law: Annotated[list[str] | None, typer.Option(help=options.LAW_HELP, show_default="every law that applies")] = None,
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
    asked = [options.parse_law(word, walker.pattern) for word in law or ()]
    chosen = LawChoice(labelled(asked), {}) if asked else every_law(walker)
    simulated = None if trace is None else load_trace(trace)
    with progress("comparing"):
        found = compare_laws(walker, chosen.laws, simulated)
    for motion in dict.fromkeys(entry.motion for entry in found.metrics):
        show(law_table(found, motion, notes=chosen.notes).text())
    numbers = allocation_results(found)
    result(allocation=numbers, omitted=dict(chosen.omitted))
    if walker.control is not None:
        note = (
            f"Under control law '{walker.control.name}' the laws share the orbit and its torques, not the multipliers: "
            "each moves otherwise off the orbit and has its own certificate (certify --law) and trace (simulate --law)."
        )
        show(note)
        result(note=note)
    if out is not None:
        wrote(write_results(out, {"allocation": numbers}))
    if figure is not None:
        for path in save(allocation_figure(walker, chosen.laws), figure):
            wrote(path)


def export(
    gait: Annotated[
        Path,
        typer.Argument(help="Gait file; or the folder of a library with transitions.", show_default=False),
    ],
    law: Annotated[str | None, typer.Option(help=options.LAW_HELP, show_default="the gait's own")] = None,
    control: Annotated[str | None, typer.Option(help=options.CONTROL_HELP, show_default="the gait's own")] = None,
    out: Annotated[
        Path, typer.Option("--out", "-o", help="Folder of the C files; or a motion: FILE.npz, FILE.csv, FILE.mat.")
    ] = Path("controller"),
    rate: Annotated[
        float | None,
        typer.Option(
            help="Rows a second: a reference motion for other programs (FILE.npz, FILE.csv, FILE.mcap).",
            show_default=False,
        ),
    ] = None,
    cycles: Annotated[
        int | None,
        typer.Option(min=1, max=10_000, help="Gait cycles of a reference motion.", show_default="1, of a trace all"),
    ] = None,
    trace: Annotated[
        Path | None, typer.Option(help="A trace of the gait's walk, written instead of the gait.", show_default=False)
    ] = None,
    order: Annotated[Order, typer.Option(help="Joints and bodies of it depth first, or as in the robot's file.")] = (
        "mujoco"
    ),
) -> None:
    """Write the controller as C: no heap, one header, a step function, test vectors and a program to replay them.

    A file name instead of a folder writes the motion, which `amble import` and other programs read; with --rate states,
    torques, forces, contacts and poses of all bodies in the coordinates of physics engines. Of a library (after `amble
    transitions`) it is one controller for all of its gaits, with a command.
    """
    if os.path.isdir(gait):
        _export_library(gait, out, others=(law, control, rate, trace))
        return
    from amble.analysis import reference_motion, write_reference
    from amble.gait.files import load_gait
    from amble.gait.motion_files import write_motion
    from amble.gait.motion_formats import FORMATS
    from amble.simulation import load_trace

    walker = load_gait(gait)
    if rate is not None:
        if law is not None or control is not None:
            raise InputError("a reference motion is that of the gait's own laws; --law and --control do not change it")
        recorded = None if trace is None else load_trace(trace)
        wrote(write_reference(reference_motion(walker, rate, cycles, order, recorded), out))
        return
    if trace is not None or out.suffix.lower() == ".mcap":
        raise InputError("a motion at a steady rate needs --rate, rows a second, such as --rate 500")
    if out.suffix.lower() in FORMATS:
        if law is not None or control is not None:
            raise InputError("a motion is that of the gait's own laws; --law and --control belong to the controller")
        wrote(write_motion(walker, out))
        return
    _export_c(options.under(walker, control), law, out)


def _export_c(walker: Gait, law: str | None, out: Path) -> None:
    """Write the controller of a gait."""
    from amble.export import export_controller

    chosen = None if law is None else options.parse_law(law, walker.pattern)
    with progress("exporting"):
        exported = export_controller(walker, chosen, out)
    for path in exported.files:
        wrote(path)
    result(law=(chosen or walker.law).name)


def _export_library(library: Path, out: Path, others: tuple[object, ...]) -> None:
    """Write the controller of a library's gaits."""
    from amble.export import export_schedule
    from amble.gait.motion_formats import FORMATS
    from amble.workflow.library import load_transitions

    if any(option is not None for option in others) or out.suffix.lower() in FORMATS:
        raise InputError("of a library the controller is exported, under its own laws; motions are those of its gaits")
    found = load_transitions(library)
    with progress("exporting"):
        exported = export_schedule(found.schedule, found.changes, out)
    for path in exported.files:
        wrote(path)
    size = 8 * found.schedule.tables.size
    show(f"tables of {found.schedule.starts[..., 0].size} gaits: {size / 1024:.0f} KiB in double, half of it in float")
    result(table_bytes=size, axes=list(found.axes))
