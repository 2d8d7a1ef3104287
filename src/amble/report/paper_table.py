"""The paper's Table 1 beside ours."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from amble.analysis import Comparison, Reduction, TorqueMetrics
from amble.report.tables import Table, number


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
