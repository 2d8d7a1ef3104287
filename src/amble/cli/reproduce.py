"""``amble reproduce``: the whole paper, from the robot to the table and the figures."""

from __future__ import annotations

import time
from importlib import resources
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from amble.cli.certify import certified
from amble.cli.console import wrote
from amble.cli.progress import progress
from amble.cli.report import GAIT, TRACE
from amble.cli.simulate import walk
from amble.cli.stabilize import BASE, METHOD_HELP, Method, stabilized
from amble.cli.synthesize import synthesized
from amble.errors import FallError

if TYPE_CHECKING:
    from amble.gait import Gait
    from amble.simulation import Trace
    from amble.stability import Certificate
    from amble.stability.stabilize import Stabilized

SPECIFICATION = "astro-amble.toml"
PERTURBATION, SEED = 1e-3, 0
"""The second simulation starts beside the orbit: every state changed by this much, up or down."""


def reproduce(
    out: Annotated[Path, typer.Option(help="Folder of the results.")] = Path("runs/astro-amble"),
    cycles: Annotated[int, typer.Option(min=1, help="Gait cycles to simulate.")] = 500,
    tolerance: Annotated[float, typer.Option(help="Tolerance of the simulation.")] = 1e-8,
    spec: Annotated[Path | None, typer.Option(help="Specification.", show_default="the paper's amble")] = None,
    method: Annotated[Method, typer.Option(help=METHOD_HELP)] = Method.BILINEAR,
) -> None:
    """Synthesise, stabilise, certify, simulate, and print the paper's Table 1 beside ours."""
    from amble.gait.files import save_gait
    from amble.report.figures import require_matplotlib

    require_matplotlib()
    clock = _Clock({})
    first, settings = _first(spec)
    wrote(save_gait(first, out / "synthesized.json"))
    clock.lap("synthesis")
    found = stabilized(first)
    wrote(save_gait(found.gait, out / GAIT))
    clock.lap("stabilisation")
    certificate = certified(found.gait, out / "certificate.json")
    clock.lap("certificate")
    trace = _walk(found.gait, cycles, tolerance, 0.0, out / TRACE)
    beside = _walk(found.gait, cycles, tolerance, PERTURBATION, out / "perturbed.nc")
    clock.lap("simulation")
    settings |= _settings(method, trace)
    _report(out, found, certificate, (trace, beside), settings, clock)


def _first(spec: Path | None) -> tuple[Gait, dict[str, str]]:
    """Return the synthesised gait and the settings of its problem that the gait does not hold."""
    from amble.synthesis.specification import read_specification

    with resources.as_file(resources.files("amble.specifications") / SPECIFICATION) as shipped:
        path = spec or shipped
        solver = read_specification(path).solver
        settings = {
            "specification": path.name,
            "tolerance of the gait problem": f"{solver.tolerance:g}",
            "intervals of a domain": str(solver.intervals * solver.refinement),
        }
        return synthesized(path), settings


def _settings(method: Method, trace: Trace) -> dict[str, str]:
    """Return the settings of everything after the gait problem."""
    from amble.stability.bilinear import TRACE
    from amble.stability.certificate import TOLERANCES

    return {
        "method of the stabilisation": method.value,
        "free weights": ", ".join(BASE),
        "trace of W in the stabilisation": f"{TRACE:g}",
        "tolerances of the certificate": ", ".join(f"{tolerance:g}" for tolerance in TOLERANCES),
        "tolerance of the simulation": f"{trace.tolerance:g}",
        "cycles": str(trace.cycles),
        "perturbation of the second start": f"{PERTURBATION:g}, seed {SEED}",
    }


def _walk(gait: Gait, cycles: int, tolerance: float, perturb: float, out: Path) -> Trace:
    from amble.gait.closed_loop import trace_units
    from amble.simulation import save_trace

    trace = walk(gait, cycles, tolerance, perturb=perturb, seed=SEED)
    wrote(save_trace(trace, out, trace_units(gait)))
    if not trace.completed:
        raise FallError(trace.ended)
    return trace


def _report(
    out: Path,
    found: Stabilized,
    certificate: Certificate,
    traces: tuple[Trace, Trace],
    settings: dict[str, str],
    clock: _Clock,
) -> None:
    """Write the page, the figures and the numbers, and print the table; the second trace starts beside the orbit."""
    from amble.report.assembly import assemble, perturbed_results
    from amble.report.run import main_table, write_run
    from amble.report.stability_results import stability_of
    from amble.stability.gait_certificate import distances, initial_spectrum

    trace, beside = traces
    with progress("measuring"):
        apart = distances(found.gait, beside, certificate)
        near = distances(found.gait, trace, certificate)
        stability = stability_of(
            initial_spectrum(found.gait),
            found,
            certificate,
            near,
            apart,
            perturbed_results(found.gait, beside, PERTURBATION, SEED),
        )
        clock.lap("measurement")
        run = assemble(found.gait, trace, settings, clock.laps, stability)
    with progress("drawing"):
        written = write_run(out, run)
    for path in written:
        wrote(path)
    typer.echo(main_table(run).text())


class _Clock:
    """Wall time of every step, s."""

    def __init__(self, laps: dict[str, float]) -> None:
        self.laps, self._last = laps, time.perf_counter()

    def lap(self, name: str) -> None:
        """End a step."""
        now = time.perf_counter()
        self.laps[name], self._last = now - self._last, now
