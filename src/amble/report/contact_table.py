"""What the monitors saw, as tables."""

from __future__ import annotations

from amble.analysis import ContactReport
from amble.report.tables import Table, number, residual_table


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
