"""``amble validate``: the exported controller of a gait on a robot that another physics engine moves."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli import options
from amble.cli.console import print_table, progress
from amble.cli.output import result, show, wrote
from amble.errors import InputError, WorkError, shown

if TYPE_CHECKING:
    from amble.validation import Case

ENGINES = ("mujoco",)


def validate(
    gait: Annotated[Path, typer.Argument(help="Gait file.", show_default=False)],
    engine: Annotated[str, typer.Option(help="Physics engine.")] = "mujoco",
    law: Annotated[str | None, typer.Option(help=options.LAW_HELP, show_default="the gait's own")] = None,
    control: Annotated[str | None, typer.Option(help=options.CONTROL_HELP, show_default="the gait's own")] = None,
    cycles: Annotated[int, typer.Option(min=1, help="Gait cycles of every walk.")] = 60,
    case: Annotated[
        list[str] | None,
        typer.Option(
            help="Case by name, of the battery or beside it (docs/validation.md); may be repeated.",
            show_default="the battery",
        ),
    ] = None,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the noise.")] = 1,
    absolute: Annotated[
        bool, typer.Option("--absolute", help="Take the cases' figures as they are, not scaled to the robot.")
    ] = False,
    record: Annotated[
        Path | None,
        typer.Option(
            help="Where to write the walk of the case, one, as a trace (netCDF) for `amble view`.", show_default=False
        ),
    ] = None,
    log: Annotated[
        Path | None, typer.Option(help="Compare this log of a robot (CSV) with the gait instead.", show_default=False)
    ] = None,
    out: Annotated[Path, typer.Option(help="Where to write the results (JSON).")] = Path("validation.json"),
) -> None:
    """Walk a gait in MuJoCo under eighteen errors of plant and measurement; exits 1 where a case does not pass."""
    if log is not None:
        if case or record is not None or absolute:
            raise InputError(
                "a log is compared with the gait, and nothing is walked: leave --case, --record, --absolute"
            )
        _compared(gait, log, out)
        return
    from amble.gait.closed_loop import trace_units
    from amble.gait.files import load_gait
    from amble.report import write_results
    from amble.simulation import save_trace
    from amble.validation import BATTERY
    from amble.validation import validate as walk

    if engine not in ENGINES:
        raise InputError(f"unknown engine '{shown(engine)}'; known: {', '.join(ENGINES)}")
    cases = _named(case) if case else BATTERY
    walker = options.under(load_gait(gait), control)
    chosen = None if law is None else options.parse_law(law, walker.pattern)
    if record is not None and len(cases) != 1:
        raise InputError("--record writes one walk: name its case, such as --case nominal")
    with progress("walking in MuJoCo") as notify:
        found = walk(walker, chosen, cases, cycles, seed, absolute, notify, record is not None)
    show(str(found))
    result(validation=found.to_dict())
    if record is not None and (trace := found.results[0].trace) is not None:
        held = {*trace.state_names, *trace.signals}
        wrote(save_trace(trace, record, {key: unit for key, unit in trace_units(walker).items() if key in held}))
    wrote(write_results(out, {"validation": found.to_dict()}))
    if found.passed < len(found.results):
        raise WorkError(f"{len(found.results) - found.passed} of {len(found.results)} cases do not pass")


def _named(names: list[str]) -> list[Case]:
    """Return the cases of these names."""
    from amble.validation import BATTERY, MORE

    known = {entry.name: entry for entry in (*BATTERY, *MORE)}
    for name in names:
        if name not in known:
            raise InputError(f"unknown case '{shown(name)}'; known: {', '.join(known)}")
    return [known[name] for name in names]


def _compared(gait: Path, log: Path, out: Path) -> None:
    """Tell how a log of a robot differs from the gait."""
    from amble.analysis.log_comparison import compare_log, read_log
    from amble.gait.files import load_gait
    from amble.report import write_results

    walker = load_gait(gait)
    found = compare_log(walker, read_log(log, walker))
    lasting = f"{found.samples} samples over {found.seconds:.3g} s"
    show(f"{lasting}: period {found.period:.4g} s, planned {found.planned:.4g} s")
    units = {joint.name: joint.unit for joint in walker.robot.joints}
    rows = [
        (joint, f"{found.errors[joint]:.4f}", f"{found.largest[joint]:.4f}", units[joint]) for joint in found.errors
    ]
    print_table(("joint", "RMS error", "largest", "unit"), rows, right=(1, 2))
    if found.rms_torque is not None:
        show(f"RMS torque {found.rms_torque:.4g} N m, planned {found.planned_torque:.4g} N m")
    result(log=found.to_dict())
    wrote(write_results(out, {"log": found.to_dict()}))
