"""From a gait and its simulation to what a report shows: both methods on both motions, monitors, settings."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

from amble.analysis import (
    LawChoice,
    compare,
    compare_laws,
    every_law,
    labelled,
    monitors,
    paper_laws,
    samples_of_gait,
    samples_of_trace,
    with_laws,
)
from amble.control import AllocationLaw
from amble.control.actuator import ACTUATORS
from amble.errors import FallError
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.hybrid import GaitPattern
from amble.progress import Progress, ProgressReport, silent
from amble.report.allocation import allocation_results, law_table
from amble.report.results import computing_versions, read_results, seconds_from, settings_from
from amble.report.run import RESULTS, RunReport, Stability, check_run, write_run
from amble.report.stability_results import stability_from
from amble.simulation import Trace, load_trace
from amble.workflow.proved import proof_beside, with_proof

GAIT, TRACE = "gait.json", "trace.nc"

SHOWN = 2
"""Cycles in the torque figure."""


def measure(
    gait: Gait,
    trace: Trace,
    settings: Mapping[str, str],
    seconds: Mapping[str, float],
    stability: Stability | None = None,
    laws: Sequence[AllocationLaw] = (),
) -> RunReport:
    """Measure a gait and its simulation for the report.

    Laws that do not apply to the gait are left out, with a sentence.

    Args:
        gait: the gait.
        trace: its simulation, at least one whole cycle.
        settings: name -> value, of the run.
        seconds: step -> wall time, s.
        stability: what the stability analysis found.
        laws: those in the table of allocation laws; every law that applies where none is given.

    Raises:
        FallError: the simulation holds no whole cycle.
    """
    if trace.cycles < 1:
        raise FallError(f"the simulated motion has no whole cycle to measure: {trace.ended}")
    methods, every = paper_laws(gait), LawChoice(labelled(laws), {}) if laws else every_law(gait)
    allocations = compare_laws(gait, every.laws)
    fitting = [model for model in ACTUATORS.entries if model.fits(gait.robot.joint_names)]
    whole = samples_of_trace(trace, gait.pattern).only(0, trace.cycles)
    last = whole.only(max(trace.cycles - SHOWN, 0), trace.cycles)
    return RunReport(
        gait=gait,
        simulated=whole,
        cycles=trace.cycles,
        two_cycles=with_laws(last, methods.laws),
        comparison=compare([samples_of_gait(gait), whole], methods.laws, fitting),
        contact=monitors(gait, trace),
        speed_achieved=whole.distance / float(whole.times[-1] - whole.times[0]),
        settings=settings,
        seconds=seconds,
        versions=computing_versions(),
        stability=stability,
        tables=(law_table(allocations, "nominal", notes=every.notes),),
        notes=methods.notes,
        extra={"allocation": allocation_results(allocations)},
    )


def rewrite_report(
    folder: str | Path,
    out: str | Path | None = None,
    laws: Callable[[GaitPattern], Sequence[AllocationLaw]] = lambda _: (),
    *,
    progress: Progress | None = None,
) -> RunReport:
    """Measure the gait and the trace of a folder and write results.json, both reports and the figures anew.

    What an earlier results.json says of stability, settings and times is kept. A proof of the gait that lies beside it
    is shown with the certificate.

    Args:
        folder: holds gait.json and trace.nc, and what an earlier run left; proof.json, where ``amble prove`` wrote one.
        out: where to write; the same folder where nothing is given.
        laws: those of a pattern in the table of allocation laws; every law that applies where there is none.
        progress: called with what is being done, and with every file that was written.

    Raises:
        InputError: a file is missing or not what it should be, or the place cannot be written.
        FallError: the trace holds no whole cycle.
    """
    notify, place = progress or silent, Path(folder)
    check_run(out or place)
    earlier = read_results(place / RESULTS)
    settings, seconds, known = settings_from(earlier), seconds_from(earlier), stability_from(earlier)
    gait, trace = load_gait(place / GAIT), load_trace(place / TRACE)
    settings = settings or {"tolerance of the simulation": f"{trace.tolerance:g}"}
    seconds = seconds or {"simulation": trace.seconds}
    notify(ProgressReport(what="measuring"))
    report = measure(gait, trace, settings, seconds, known, laws(gait.pattern))
    report = with_proof(report, *proof_beside(place, gait))
    notify(ProgressReport(what="drawing"))
    for path in write_run(out or place, report):
        notify(ProgressReport(what="wrote", file=path))
    return report
