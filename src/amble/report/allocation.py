"""Allocation laws side by side: their table, its numbers, and the figure of the torques."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from math import isfinite
from typing import TYPE_CHECKING

from amble.analysis import Comparison, LawMetrics, Samples, every_law, samples_of_gait, with_laws
from amble.control.allocation import AllocationLaw
from amble.gait import Gait
from amble.report.figures import left_joints, torque_lines
from amble.report.results import finite_or_none
from amble.report.tables import Table, number
from amble.types import Json

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def law_table(
    comparison: Comparison, motion: str, actuators: Sequence[str] | None = None, notes: Sequence[str] = ()
) -> Table:
    """Put all laws along one motion side by side: cost for every actuator model, torques, and use of the limits.

    Args:
        comparison: the metrics.
        motion: label of the motion.
        actuators: names of the actuator models; all where none are given.
        notes: further sentences below the table, such as which laws are left out and why.

    Raises:
        UnknownNameError: where the comparison lacks the motion or a model.
    """
    entries = comparison.along(motion)
    models = tuple(entries[0].energy) if actuators is None else tuple(actuators)
    walks = all(isfinite(entry.energy[model].cot) for entry in entries for model in models)
    measure, key = ("CoT", "cot") if walks else ("power/weight in m/s", "specific_power")
    header = [
        "law",
        *(f"{measure} ({model})" for model in models),
        "RMS (N m)",
        "peak (N m)",
        "peak joint",
    ]
    note = f"All laws on the same {motion} motion; {measure} by actuator model, in brackets."
    if entries[0].limits is not None:
        header += ["relative peak", "friction used", "limit active (%)", "limit missed (%)"]
        note = f"{note[:-1]}; limits are the gait's and the robot's own."
    rows = tuple(
        (
            entry.law,
            *(number(getattr(comparison.of(entry.law, motion, model), key)) for model in models),
            number(entry.torques.rms_torque),
            number(entry.torques.peak_torque),
            entry.torques.peak_joint,
            *_limit_cells(entry),
        )
        for entry in entries
    )
    return Table(f"Allocation laws along the {motion} motion", tuple(header), rows, (note, *notes))


def _limit_cells(entry: LawMetrics) -> tuple[str, ...]:
    if entry.limits is None:
        return ()
    used = entry.limits
    ratios = (number(used.peak_relative_torque, 3), number(used.friction_used, 3))
    return (*ratios, f"{100.0 * used.active:.1f}", f"{100.0 * used.missed:.1f}")


def _limit_numbers(entry: LawMetrics) -> Json:
    if entry.limits is None:
        return {}
    return {**asdict(entry.limits), "friction_used": finite_or_none(entry.limits.friction_used)}


def allocation_results(comparison: Comparison) -> Json:
    """Return label -> motion -> metrics, for results.json under "allocation"; N m, N.

    The friction used of a law under which a foot pulls is infinite, as is the cost of transport where no distance is
    walked; JSON does not have that: None.
    """
    found: Json = {}
    for entry in comparison.metrics:
        torques = entry.torques
        found.setdefault(entry.law, {})[entry.motion] = {
            "cot": {model: finite_or_none(energy.cot) for model, energy in entry.energy.items()},
            "specific_power": {model: energy.specific_power for model, energy in entry.energy.items()},
            "rms_torque": torques.rms_torque,
            "peak_torque": torques.peak_torque,
            "peak_joint": torques.peak_joint,
            **_limit_numbers(entry),
        }
    return found


def allocation_figure(
    gait: Gait, laws: Mapping[str, AllocationLaw] | None = None, samples: Samples | None = None
) -> Figure:
    """Draw the torques of the left legs under every law over one cycle."""
    motion = samples_of_gait(gait) if samples is None else samples
    chosen = every_law(gait).laws if laws is None else laws
    return torque_lines(with_laws(motion, chosen), left_joints(gait.robot))
