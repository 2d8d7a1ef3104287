"""Allocation laws side by side: the table of ``amble compare``, its numbers, and the figure of the torques."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from typing import TYPE_CHECKING

from amble.analysis import Samples, every_law, samples_of_gait
from amble.analysis.allocation import LawMetrics, law_torques
from amble.control.allocation import AllocationLaw
from amble.gait import Gait
from amble.report.figures import left_joints, torque_lines
from amble.report.results import finite_or_none
from amble.report.tables import Table
from amble.types import Json

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def allocation_table(metrics: Sequence[LawMetrics], notes: Sequence[str] = ()) -> Table:
    """Put all laws along one motion side by side.

    Args:
        metrics: of the laws, at least one.
        notes: further sentences below the table, such as which laws are left out and why.
    """
    models = list(metrics[0].cot)
    header = (
        "law",
        *(f"CoT ({model})" for model in models),
        "RMS (N m)",
        "peak (N m)",
        "relative peak",
        "friction used",
        "limit active (%)",
        "limit missed (%)",
    )
    rows = tuple(
        (
            entry.law,
            *(f"{entry.cot[model]:.4f}" for model in models),
            f"{entry.rms_torque:.3f}",
            f"{entry.peak_torque:.3f}",
            f"{entry.peak_relative_torque:.3f}",
            f"{entry.friction_used:.3f}",
            f"{100.0 * entry.active:.1f}",
            f"{100.0 * entry.missed:.1f}",
        )
        for entry in metrics
    )
    motion = metrics[0].motion
    note = f"All laws on the same {motion} motion; limits are the gait's and the robot's own."
    return Table(f"Allocation laws along the {motion} motion", header, rows, (note, *notes))


def allocation_results(metrics: Sequence[LawMetrics]) -> Json:
    """Return label -> motion -> metrics, for results.json under "allocation"; N m, N.

    The friction used of a law under which a foot pulls is infinite, which JSON does not have: None.
    """
    found: Json = {}
    for entry in metrics:
        numbers = {key: value for key, value in asdict(entry).items() if key not in ("law", "motion")}
        numbers["friction_used"] = finite_or_none(entry.friction_used)
        found.setdefault(entry.law, {})[entry.motion] = numbers
    return found


def allocation_figure(
    gait: Gait, laws: Mapping[str, AllocationLaw] | None = None, samples: Samples | None = None
) -> Figure:
    """Draw the torques of the left legs under every law over one cycle."""
    motion = samples_of_gait(gait) if samples is None else samples
    torques = law_torques(motion, every_law(gait).laws if laws is None else laws)
    return torque_lines(motion.motion(torques), left_joints(gait.robot))
