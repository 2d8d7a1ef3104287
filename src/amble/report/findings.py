"""What a run found, as tables: the paper's Table 1 beside ours, contacts along the motion, stability."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from amble.analysis import Comparison, ContactReport, Reduction, TorqueMetrics
from amble.report.tables import Table, number, residual_table

NOTES = (
    "Of a full cycle; the error bar is an estimate, and the radius before stabilisation has none. Section error: "
    "distance from the fixed point at the end of the last cycle, norm of all states modulo the symmetries.",
)


@dataclass(frozen=True)
class Published:
    """One row of a published table: CoT, peak torque in N m, RMS torque in N m."""

    cot: float
    peak_torque: float
    rms_torque: float


PAPER_ROWS = {"drop": Published(6.389, 83.97, 9.659), "pinv": Published(4.532, 66.55, 7.932)}
"""Table 1 of Lysø, Grøtli and Pettersen (2023), by law."""

PAPER_REDUCTION = Published(29.1, 20.7, 17.9)
"""Reductions in percent, as the text of the paper gives them."""

METHODS = {"drop": "Ma et al. 2019 (one actuator off)", "pinv": "proposed (pseudo-inverse)"}

WHY_DIFFERENT = (
    "Our numbers need not equal the paper's, because they belong to another orbit: the paper publishes neither its "
    "gait nor all of the bounds behind it, and our domains may last longer."
)

HEADER = ("method", "from", "actuator", "CoT", "peak torque (N m)", "RMS torque (N m)")


def paper_table(comparison: Comparison, motions: Sequence[str], actuators: Sequence[str]) -> Table:
    """Put the paper's Table 1 and ours into one table, each number labelled with its actuator model.

    Args:
        comparison: metrics of the laws "drop" and "pinv".
        motions: labels of the motions to show.
        actuators: names of the actuator models to show.

    Raises:
        UnknownNameError: where the comparison lacks a law, motion or model.
    """
    rows = []
    for law, method in METHODS.items():
        published = PAPER_ROWS[law]
        rows.append((method, "paper", "paper", *_cells(published)))
        for actuator in actuators:
            rows += [
                (method, f"ours, {motion}", actuator, *_cells(comparison.of(law, motion, actuator)))
                for motion in motions
            ]
    rows.append(("reduction in percent", "paper", "paper", *_percents(PAPER_REDUCTION)))
    for actuator in actuators:
        for motion in motions:
            found = comparison.reduction("drop", "pinv", motion, actuator)
            rows.append(("reduction in percent", f"ours, {motion}", actuator, *_percents(found)))
    return Table(
        "Cost of transport and torques, the paper's Table 1 beside ours", HEADER, tuple(rows), (WHY_DIFFERENT,)
    )


def has_both_methods(comparison: Comparison) -> bool:
    """Whether both of the paper's methods were measured; one actuator off does not apply to every gait."""
    return set(METHODS) <= set(comparison.laws)


def _cells(entry: Published | TorqueMetrics) -> tuple[str, str, str]:
    return number(entry.cot), number(entry.peak_torque), number(entry.rms_torque)


def _percents(entry: Published | Reduction) -> tuple[str, str, str]:
    return f"{entry.cot:.1f}", f"{entry.peak_torque:.1f}", f"{entry.rms_torque:.1f}"


def contact_summary(report: ContactReport) -> Table:
    """Summarise a contact report: one quantity a row, its worst value over the whole motion."""
    rows = (
        ("smallest normal force of a stance foot (N)", number(report.min_normal_force)),
        ("largest friction used, |f_t| / f_n", number(report.max_friction)),
        ("largest penetration of a swing foot (m)", number(report.max_penetration)),
        ("largest drift of a stance foot (m)", number(report.max_drift)),
        ("largest distance of a landing foot from the ground (m)", number(report.max_landing_gap)),
        ("largest speed of a stance foot (m/s)", number(report.max_slip)),
        ("smallest pivot of the decoupling equations", number(report.min_pivot)),
        ("samples in which a stance foot does not push", str(report.pulls)),
        ("samples looked at", str(report.samples)),
    )
    if report.sound_from is None:
        note = "The contacts of the last cycle are not sound."
    elif report.sound_from == 0:
        note = "Normal forces are positive and friction is inside the cone in every cycle."
    else:
        note = f"Normal forces are positive and friction is inside the cone from cycle {report.sound_from} on."
    return Table("Contacts along the simulated motion", ("quantity", "worst value"), rows, (note,))


def contact_rows(report: ContactReport, only_violations: bool = False) -> Table:
    """List every monitored quantity with its bounds and when its worst value occurred.

    Args:
        report: the report.
        only_violations: leave out what keeps its bounds.
    """
    chosen = report.violations if only_violations else report.rows
    count = len(report.violations)
    note = (
        f"{count} of {len(report.rows)} monitored quantities leave their bounds." if count else "All keep their bounds."
    )
    return residual_table("Monitored quantities", chosen, (note,))


def stability_table(results: Mapping[str, Any]) -> Table:
    """Summarise the stability entries of results.json; an entry that a run does not have gives no rows.

    Args:
        results: holds the entries that ``stability_results.ENTRIES`` describes, ``spectral_radius`` at least.
    """
    radius = results["spectral_radius"]
    rows = [
        ("spectral radius before stabilisation", number(float(radius["initial"]))),
        ("spectral radius after stabilisation", number(float(radius["stabilized"]))),
        ("its error bar", number(float(radius["error"]), 2)),
    ]
    bound = radius.get("contraction_bound")
    if bound is not None:
        rows.append(("contraction bound of the cycle, verified", number(float(bound))))
    found = results.get("contraction")  # None where the mode decays too fast to be measured
    if found is not None:
        rows += [
            ("leading mode, contraction predicted", number(float(found["predicted"]))),
            ("leading mode, contraction measured in simulation", number(float(found["measured"]))),
            ("relative difference of the two", number(float(found["relative_difference"]), 2)),
        ]
    starts = {"section_error": "start on the orbit", "section_error_perturbed": "perturbed start"}
    known = {key: start for key, start in starts.items() if results.get(key) is not None}
    rows += [(f"section error, {start}", number(float(results[key]), 2)) for key, start in known.items()]
    if results.get("perturbed") is not None:
        rows += _perturbed(results["perturbed"])
    return Table("Stability", ("quantity", "value"), tuple(rows), NOTES)


def _perturbed(found: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Say how the perturbed start did: until its contacts are sound, and the worst of them before that."""
    until = found.get("sound_from_cycle")
    rows = [
        ("perturbed start, change of every state", number(float(found["size"]), 2)),
        ("perturbed start, cycles", str(int(found["cycles"]))),
        ("perturbed start, contacts sound from cycle", "-" if until is None else str(int(until))),
    ]
    before = found.get("before_sound")
    if before is None:
        return rows
    used = before["max_friction"]  # None where a foot pulled
    return [
        *rows,
        ("perturbed start, largest friction used before that", "inf" if used is None else number(float(used))),
        ("perturbed start, smallest normal force before that (N)", number(float(before["min_normal_force"]))),
    ]
