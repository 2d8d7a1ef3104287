"""Multipliers of an orbit in the complex plane, before and after stabilisation."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from amble.report.figures.style import BLUE, GREY, PAGE, VERMILION, legend_above, panels, paper_style

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloquetMultipliers = NDArray[np.complex128]


def multiplier_circle(before: FloquetMultipliers, after: FloquetMultipliers) -> Figure:
    """Draw multipliers with the unit circle: all of them on the left, the neighbourhood of the circle on the right.

    Args:
        before: multipliers of the orbit under the outputs of the gait problem, (n,).
        after: multipliers under the stabilised outputs, (n,).
    """
    with paper_style():
        figure, (whole, near) = panels(1, 2, PAGE, 3.7)
        for axes in (whole, near):
            _draw(axes, before, after)
        reach = 1.15 * max(1.0, float(np.max(np.abs(np.concatenate([before, after])))))
        for axes, limit, title in ((whole, reach, "all multipliers"), (near, 1.25, "near the unit circle")):
            axes.set_xlim(-limit, limit)
            axes.set_ylim(-limit, limit)
            axes.set_title(title)
        outside = int(np.sum(np.maximum(np.abs(before.real), np.abs(before.imag)) > 1.25))
        if outside:
            near.set_title(f"near the unit circle ({outside} of the initial ones lie outside)")
        legend_above(figure, whole, 3)
    return figure


def _draw(axes: Axes, before: FloquetMultipliers, after: FloquetMultipliers) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color=GREY, linewidth=0.8, label="unit circle")
    for values, colour, marker, label in (
        (before, VERMILION, "x", rf"before, $\rho$ = {_radius(before):.4g}"),
        (after, BLUE, "o", rf"after, $\rho$ = {_radius(after):.4g}"),
    ):
        axes.plot(
            values.real,
            values.imag,
            linestyle="none",
            marker=marker,
            color=colour,
            label=label,
            markersize=4.5,
            fillstyle="none",
        )
    axes.set_aspect("equal")
    axes.set_xlabel(r"Re $\lambda$")
    axes.set_ylabel(r"Im $\lambda$")


def _radius(values: FloquetMultipliers) -> float:
    return float(np.max(np.abs(values)))
