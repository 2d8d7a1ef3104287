"""Everything a run leaves in its folder: figures, report.md, report.html and results.json."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING

from amble.analysis import Comparison, ContactReport, Motion, Samples, actuators_for, is_papers, samples_of_gait
from amble.gait import Gait
from amble.io.storage import confined, file_at
from amble.report.allocation import law_table
from amble.report.figures import (
    base_portraits,
    contact_forces,
    cycle_portraits,
    foot_paths,
    footfall,
    joint_portraits,
    joint_power,
    left_joints,
    multiplier_circle,
    save,
    section_distance,
    torque_magnitudes,
    torque_speed,
)
from amble.report.figures.orbital_stability import FloquetMultipliers
from amble.report.findings import contact_rows, contact_summary, has_both_methods, paper_table, stability_table
from amble.report.hover import hover_figure
from amble.report.html import write_html
from amble.report.page import FigureFile, Page, solver_table, write_page
from amble.report.results import (
    FORMAT,
    FORMAT_VERSION,
    contact_results,
    method_results,
    reduction_results,
    solver_results,
    write_results,
)
from amble.report.tables import Table
from amble.types import Json, Vector
from amble.view import replay

if TYPE_CHECKING:
    from matplotlib.figure import Figure

RESULTS, PAGE, HTML, FIGURES = "results.json", "report.md", "report.html", "figures"
"""Names of what is written into the folder of a run."""

STEMS = (
    "base_portraits",
    "joint_portraits",
    "footfall",
    "torques",
    "torque_speed",
    "joint_power",
    "foot_paths",
    "contact_forces",
    "cycle_portraits",
    "multipliers",
    "section_distance",
)
"""Names of the figures, without suffix."""

REPLAYED_CYCLES = 5
"""Cycles of each motion in the page's replay."""

PORTRAIT_CYCLES = 2
"""Simulated cycles in the portraits that compare with the optimised motion."""


@dataclass(frozen=True)
class Stability:
    """What the stability analysis gives the report.

    Attributes:
        before: multipliers of the full cycle under the outputs of the gait problem.
        after: multipliers of the full cycle under the stabilised outputs.
        radius: spectral radius of the full cycle under the stabilised outputs.
        distances: distance of the simulated motion from the fixed point at the entry of every cycle, (cycles + 1,).
        results: what goes into results.json, such as spectral_radius and stabilization.
    """

    before: FloquetMultipliers
    after: FloquetMultipliers
    radius: float
    distances: Vector
    results: Json


@dataclass(frozen=True, kw_only=True)
class RunReport:
    """What a run leaves in its folder: the gait, its simulation and what was measured on them.

    Attributes:
        gait: the gait.
        simulated: samples of all simulated cycles.
        cycles: number of completed cycles.
        two_cycles: two consecutive cycles with the torques of the laws, for the torque figure.
        comparison: metrics of the laws "pinv" and, where it applies, "drop" on the motions "nominal" and "simulated",
            for the models "paper" and "datasheet".
        contact: what the monitors saw.
        speed_achieved: mean forward speed of the simulated motion, m/s.
        settings: name -> value, text, of the run.
        seconds: step of the run -> wall time, s.
        versions: library that computes -> version, of the process that measured the run.
        stability: where the run has it.
        tables: further tables for the page.
        notes: sentences for the page, such as which of the paper's laws is left out and why.
        extra: further entries for results.json.
    """

    gait: Gait
    simulated: Samples
    cycles: int
    two_cycles: Motion
    comparison: Comparison
    contact: ContactReport
    speed_achieved: float
    settings: Mapping[str, str]
    seconds: Mapping[str, float]
    versions: Mapping[str, str]
    stability: Stability | None = None
    tables: tuple[Table, ...] = ()
    notes: tuple[str, ...] = ()
    extra: Json = field(default_factory=dict)


def main_table(run: RunReport) -> Table:
    """Return the paper's Table 1 beside ours for its own gait; for any other, what our laws take."""
    if not (is_papers(run.gait) and has_both_methods(run.comparison)):
        return law_table(run.comparison, "simulated", [model.name for model in actuators_for(run.gait)])
    return paper_table(run.comparison, ("nominal", "simulated"), ("paper", "datasheet"))


def run_results(run: RunReport) -> Json:
    """Return the content of results.json; what the paper's own actuator model gives for the paper's own gait only."""
    stability = run.stability.results if run.stability is not None else {}
    models = {"": "paper", "_datasheet": "datasheet"} if is_papers(run.gait) else {"_datasheet": "datasheet"}
    reductions = models if has_both_methods(run.comparison) else {}
    return {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "robot": run.gait.robot.name,
        "gait": run.gait.pattern.name,
        "law": run.gait.law.name,
        "speed_desired": run.gait.speed,
        "speed_achieved": run.speed_achieved,
        "period": run.gait.period,
        "cycles": run.cycles,
        **{f"methods{key}": method_results(run.comparison, model) for key, model in models.items()},
        **{
            f"reduction{key}": reduction_results(run.comparison, "simulated", model)
            for key, model in reductions.items()
        },
        "contact": contact_results(run.contact),
        "solver": solver_results(run.gait.solver),
        **stability,
        **run.extra,
        "settings": dict(run.settings),
        "seconds": dict(run.seconds),
        "versions": dict(run.versions),
    }


def run_figures(run: RunReport) -> dict[str, tuple[Figure, str]]:
    """Draw all figures: file stem -> figure and caption."""
    optimised = samples_of_gait(run.gait)
    first = int(run.simulated.cycles[0])
    few = run.simulated.only(first, first + PORTRAIT_CYCLES)
    durations = [domain.duration for domain in run.gait.domains]
    robot = run.gait.robot.name
    drawn = {
        "base_portraits": (
            base_portraits(optimised, few),
            f"Phase portraits of the base of {robot}, optimised and simulated ({PORTRAIT_CYCLES} cycles).",
        ),
        "joint_portraits": (
            joint_portraits(optimised, few),
            f"Phase portraits of the joints of {robot}, optimised and simulated ({PORTRAIT_CYCLES} cycles).",
        ),
        "footfall": (footfall(run.gait.pattern, durations), f"One cycle of the gait '{run.gait.pattern.name}'."),
        **_torque_figures(run),
        "foot_paths": (foot_paths(optimised), "Paths of the feet over the ground, seen from the side."),
        "contact_forces": (
            contact_forces(optimised),
            "Contact forces of one cycle, and what the friction cone allows.",
        ),
        "cycle_portraits": (
            cycle_portraits(run.simulated),
            f"Phase portraits of the base over {run.cycles} simulated cycles, thinned.",
        ),
    }
    if run.stability is not None:
        found = run.stability
        drawn["multipliers"] = (
            multiplier_circle(found.before, found.after),
            "Multipliers of the full cycle before and after stabilisation, with the unit circle.",
        )
        drawn["section_distance"] = (
            section_distance(found.distances, found.radius),
            "Distance from the fixed point at the entry of every cycle, and the slope the spectral radius predicts.",
        )
    return drawn


def _torque_figures(run: RunReport) -> dict[str, tuple[Figure, str]]:
    """Draw torques over time and over speed, and power."""
    # the right legs of a mirrored gait do what the left ones do, half a cycle later
    mirrored = run.gait.pattern.mirrored and bool(left_joints(run.gait.robot))
    joints = left_joints(run.gait.robot) if mirrored else run.gait.robot.joint_names
    legs = "the left legs" if mirrored else "all legs"
    legs += ", forces at an arm of the leg length," * any(joint.prismatic for joint in run.gait.robot.joints)
    last = list(run.two_cycles.torques)[-1]
    motor = actuators_for(run.gait)[0]
    return {
        "torques": (
            torque_magnitudes(run.two_cycles, joints),
            f"Absolute value of the torques of {legs} over two cycles, all laws on the same motion.",
        ),
        "torque_speed": (
            torque_speed(run.two_cycles, run.gait.robot, joints),
            f"Torque against speed of {legs}; dotted, limits that the motion comes near.",
        ),
        "joint_power": (
            joint_power(run.two_cycles, last, motor),
            f"Mean power of every joint, law '{last}', motor '{motor.name}'.",
        ),
    }


def write_run(folder: str | Path, run: RunReport) -> tuple[Path, ...]:
    """Write results.json, the figures, report.md and report.html into a folder; every file whole or not at all.

    Returns:
        The paths that were written, the numbers first.

    Raises:
        InputError: where the place cannot be written.
        WorkError: where a result is not finite.
    """
    place = Path(folder)
    with confined(place):
        written = [write_results(place / RESULTS, run_results(run))]
        figures, drawn = [], []
        for stem, (figure, caption) in run_figures(run).items():
            written += save(figure, place / FIGURES / stem)
            figures.append(FigureFile(f"{FIGURES}/{stem}", caption))
            drawn.append((hover_figure(figure), caption))
        page = _page(run, tuple(figures))
        written.append(write_page(place / PAGE, page))
        shown = replay(run.gait, run.simulated, cycles=REPLAYED_CYCLES)
        written.append(write_html(place / HTML, page, drawn, shown.replays))
    return tuple(written)


def _page(run: RunReport, figures: tuple[FigureFile, ...]) -> Page:
    return Page(
        title=f"{run.gait.robot.name}: {run.gait.pattern.name} at {run.gait.speed:g} m/s",
        summary=(_summary(run), *run.notes),
        tables=(
            main_table(run),
            *(() if run.stability is None else (stability_table(run.stability.results),)),
            contact_summary(run.contact),
            contact_rows(run.contact),
            solver_table(run.gait.solver, run.gait.cost.unit),
            *run.tables,
        ),
        figures=figures,
        settings={**run.settings, **{f"seconds, {step}": f"{value:.2f}" for step, value in run.seconds.items()}},
        versions=run.versions,
    )


def _summary(run: RunReport) -> str:
    sentences = [
        f"{run.cycles} cycles were simulated at {run.speed_achieved:.4f} m/s "
        f"({run.gait.speed:g} m/s asked for), {run.gait.period:.4f} s a cycle on the optimised motion."
    ]
    if has_both_methods(run.comparison):
        reduction = run.comparison.reduction("drop", "pinv", "simulated", actuators_for(run.gait)[0].name)
        sentences.append(
            f"On the simulated motion the pseudo-inverse takes {reduction.cot:.1f} % less cost of transport, "
            f"{reduction.rms_torque:.1f} % less RMS torque and {reduction.peak_torque:.1f} % less peak torque than the "
            f"dropped actuator (actuator model '{reduction.actuator}')."
        )
    if run.stability is not None:
        sentences.append(f"Spectral radius of the full cycle: {run.stability.radius:.4f}.")
    return " ".join(sentences)


def check_run(folder: str | Path) -> None:
    """Refuse a folder in which a file of ``write_run`` could not be written, before the work whose result it is.

    Raises:
        InputError: something is in the way, is protected, or is a link that leads elsewhere.
    """
    with confined(folder):
        for path in run_files(folder):
            file_at(path)


def run_files(folder: str | Path) -> tuple[Path, ...]:
    """Return every path that ``write_run`` may write into a folder."""
    place = Path(folder)
    figures = [place / FIGURES / f"{stem}.{suffix}" for stem in STEMS for suffix in ("png", "pdf")]
    return (place / RESULTS, place / PAGE, place / HTML, *figures)
