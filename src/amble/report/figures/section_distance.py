"""Distance of a simulated motion from the fixed point of the section, cycle by cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from amble.errors import InputError
from amble.report.figures.style import BLUE, PAGE, VERMILION, legend_above, panels, paper_style
from amble.types import IntegerVector, Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

LEAST_SHOWN = 10
"""Cycles that the panel of the approach shows at least."""


def section_distance(distances: Vector, radius: float) -> Figure:
    """Draw the distance on a log axis over the cycles, and the slope that the spectral radius predicts.

    All cycles on the left; on the right the approach, up to where the distance no longer falls.

    Args:
        distances: distance at the entry of every cycle, (cycles + 1,), with positive values; zeros are not drawn.
        radius: spectral radius of the full cycle.

    Raises:
        InputError: where no distance is positive.
    """
    drawn = np.flatnonzero(distances > 0.0)
    if drawn.size == 0:
        raise InputError("no distance from the fixed point is positive; there is nothing to draw on a log axis")
    # the level that round-off and the integrator keep the simulation at
    floor = float(np.median(distances[drawn][-(1 + drawn.size // 2) :]))
    arrived = int(drawn[np.argmax(distances[drawn] <= 3.0 * floor)])
    with paper_style():
        figure, (whole, approach) = panels(1, 2, PAGE, 2.4, sharey=True)
        for axes in (whole, approach):
            _draw(axes, distances, drawn, radius, floor)
        approach.set_xlim(-0.5, min(len(distances) - 0.5, max(LEAST_SHOWN, 1.3 * arrived) + 0.5))
        whole.set_ylabel("distance from the fixed point")
        legend_above(figure, whole, 2)
    return figure


def _draw(axes: Axes, distances: Vector, drawn: IntegerVector, radius: float, floor: float) -> None:
    axes.semilogy(drawn, distances[drawn], ".", markersize=3.5, color=BLUE, label="simulated")
    predicted = distances[drawn[0]] * radius ** (drawn - drawn[0]).astype(np.float64)
    shown = predicted >= 0.3 * floor
    axes.semilogy(drawn[shown], predicted[shown], "--", color=VERMILION, label=rf"$\rho^k$ with $\rho$ = {radius:.4g}")
    axes.set_xlabel("cycle $k$")
