"""The whole paper: from the specification to the gait, its certificate, its simulation and the report."""

from __future__ import annotations

import os
import time
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TypeVar

from amble.defaults import CERTIFICATE, METHOD, REPRODUCED_CYCLES, TOLERANCE, Method
from amble.errors import FallError
from amble.gait import Gait
from amble.gait.closed_loop import trace_units
from amble.gait.files import save_gait
from amble.io.storage import confined, folder_at
from amble.progress import Progress, ProgressReport, silent
from amble.report.run import RunReport, Stability, run_files, write_run
from amble.report.stability_results import perturbed_results, stability_of
from amble.simulation import Trace, save_trace, simulate
from amble.simulation.simulate import SAMPLES
from amble.simulation.walk import check_record, check_tolerance
from amble.stability import Certificate
from amble.stability.certificate import TOLERANCES
from amble.stability.gait_certificate import distances, initial_spectrum
from amble.stability.stabilize import Stabilized, stabilization
from amble.stability.weight_search import TRACE as TRACE_BOUND
from amble.synthesis.specification import Specification
from amble.workflow.certify import certify_into
from amble.workflow.measure import GAIT, TRACE, measure
from amble.workflow.specified import PosedProblem, pose, solve

SYNTHESIZED, PERTURBED = "synthesized.json", "perturbed.nc"

PERTURBATION, SEED = 1e-3, 0
"""The second simulation starts beside the orbit: every state changed by this much, up or down."""

Value = TypeVar("Value")


@dataclass(frozen=True, kw_only=True)
class Run:
    """What a reproduction found.

    Attributes:
        synthesized: the gait of the specification.
        stabilized: the gait with stabilised outputs, and how it came about.
        certificate: of the stabilised gait.
        trace: simulated from the orbit.
        perturbed: simulated from beside it.
        report: what was measured, as the report shows it.
        files: what was written, in order; empty where nothing was to be.
    """

    synthesized: Gait
    stabilized: Stabilized
    certificate: Certificate
    trace: Trace
    perturbed: Trace
    report: RunReport
    files: tuple[Path, ...]

    @property
    def gait(self) -> Gait:
        """The stabilised gait."""
        return self.stabilized.gait


def reproduce(
    specification: Specification | PosedProblem | str | Path | None = None,
    out: str | Path | None = None,
    *,
    method: Method = METHOD,
    cycles: int = REPRODUCED_CYCLES,
    tolerance: float = TOLERANCE,
    progress: Progress | None = None,
) -> Run:
    """Synthesise, stabilise, certify, simulate and measure; by default the paper's amble of ASTRo.

    Args:
        specification: a file, which is read once, at the beginning; or what ``amble.read_specification`` or
            ``workflow.specified.pose`` returned; by default the paper's amble.
        out: folder to write gaits, certificate, traces, results.json, report.md, report.html and figures into, each as
            soon as it is known. What an earlier run left there under these names is removed once the new gait is
            found, so that nothing in the folder belongs to another gait. Nothing is written where it is not given.
        method: what chooses the output weights.
        cycles: gait cycles to simulate.
        tolerance: of the simulation.
        progress: called with what is being done, and with every file that was written.

    Raises:
        InputError, UnknownNameError: the specification or a number cannot be used, or the folder cannot be written.
        NotSolvedError: the gait problem has no solution that was found.
        NotStabilizedError: the orbit stays unstable.
        CertificateError: the certificate is refused; certificate.json then says so, with the reasons.
        FallError: a simulation did not walk all its cycles; its trace is written.
    """
    check_tolerance(tolerance)  # before the work whose result it would spoil
    posed = specification if isinstance(specification, PosedProblem) else pose(specification)
    check_record(cycles, SAMPLES, len(posed.problem.pattern.visited), 2 * posed.problem.pattern.robot.size)
    work = _Work(None if out is None else Path(out), progress or silent)
    gait = work.timed("synthesis", lambda: solve(posed, progress=work.notify))
    work.clear()
    work.write(SYNTHESIZED, lambda path: save_gait(gait, path))
    found = work.timed("stabilisation", lambda: stabilization(gait, method=method, progress=work.notify))
    work.write(GAIT, lambda path: save_gait(found.gait, path))
    certificate = work.timed("certificate", lambda: work.certified(found.gait))
    trace, beside = work.timed(
        "simulation",
        lambda: (
            work.walk(found.gait, cycles, tolerance, 0.0, TRACE),
            work.walk(found.gait, cycles, tolerance, PERTURBATION, PERTURBED),
        ),
    )
    stability = work.timed("measurement", lambda: _stability(found, certificate, trace, beside))
    report = measure(found.gait, trace, _settings(posed, found, method, trace), dict(work.seconds), stability)
    work.draw(report)
    return Run(
        synthesized=gait,
        stabilized=found,
        certificate=certificate,
        trace=trace,
        perturbed=beside,
        report=report,
        files=tuple(work.files),
    )


class _Work:
    """Where a reproduction writes, whom it tells, how long its steps took (s), and what it has written."""

    def __init__(self, out: Path | None, notify: Progress) -> None:
        self.out, self.notify = out, notify
        self.seconds: dict[str, float] = {}
        self.files: list[Path] = []

    def place(self, name: str) -> Path | None:
        """Return where a file goes; None where nothing is written."""
        return None if self.out is None else self.out / name

    def timed(self, step: str, work: Callable[[], Value]) -> Value:
        """Do one step, say which, and note its wall time."""
        self.notify(ProgressReport(what=step))
        began = time.perf_counter()
        result = work()
        self.seconds[step] = time.perf_counter() - began
        return result

    def keep(self, report: ProgressReport) -> None:
        """Pass on what is told, and note the files."""
        if report.file is not None:
            self.files.append(report.file)
        self.notify(report)

    def write(self, name: str, save: Callable[[Path], Path]) -> None:
        """Write a file, where files are written."""
        place = self.place(name)
        if self.out is not None and place is not None:
            with confined(self.out):
                self.keep(ProgressReport(what="wrote", file=save(place)))

    def certified(self, gait: Gait) -> Certificate:
        """Certify a gait, and write the certificate where files are written."""
        with confined(self.out or os.curdir):
            return certify_into(gait, self.place(CERTIFICATE), progress=self.keep)

    def draw(self, report: RunReport) -> None:
        """Write figures, page and results, where files are written."""
        if self.out is None:
            return
        self.notify(ProgressReport(what="drawing"))
        for path in write_run(self.out, report):
            self.keep(ProgressReport(what="wrote", file=path))

    def clear(self) -> None:
        """Remove what an earlier run left: it belongs to another gait."""
        if self.out is None:
            return
        names = (SYNTHESIZED, GAIT, CERTIFICATE, TRACE, PERTURBED)
        for path in (*(self.out / name for name in names), *run_files(self.out)):
            if os.path.isfile(path):
                with confined(self.out):
                    (folder_at(path.parent) / path.name).unlink()

    def walk(self, gait: Gait, cycles: int, tolerance: float, perturbation: float, name: str) -> Trace:
        """Simulate and write the trace; a fall is an error that leaves the trace."""
        trace = simulate(
            gait, cycles=cycles, tolerance=tolerance, perturbation=perturbation, seed=SEED, progress=self.notify
        )
        self.write(name, lambda path: save_trace(trace, path, trace_units(gait)))
        if not trace.completed:
            raise FallError(trace.ended)
        return trace


def _settings(posed: PosedProblem, found: Stabilized, method: Method, trace: Trace) -> dict[str, str]:
    """Return the settings that the gait itself does not hold."""
    solver = posed.solver
    return {
        "specification": posed.name,
        "tolerance of the gait problem": f"{solver.tolerance:g}",
        "intervals of a domain": str(found.gait.domains[0].intervals),
        "method of the stabilisation": method,
        "free weights": ", ".join(found.free),
        "trace of W in the stabilisation": f"{TRACE_BOUND:g}",
        "tolerances of the certificate": ", ".join(f"{tolerance:g}" for tolerance in TOLERANCES),
        "tolerance of the simulation": f"{trace.tolerance:g}",
        "cycles": str(trace.cycles),
        "perturbation of the second start": f"{PERTURBATION:g}, seed {SEED}",
    }


def _stability(found: Stabilized, certificate: Certificate, trace: Trace, beside: Trace) -> Stability:
    return stability_of(
        initial_spectrum(found.gait),
        found,
        certificate,
        distances(found.gait, trace, certificate),
        distances(found.gait, beside, certificate),
        perturbed_results(found.gait, beside, PERTURBATION, SEED),
    )
