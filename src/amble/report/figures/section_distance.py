"""Distance of a simulated motion from the fixed point of the section, cycle by cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from amble.errors import InputError
from amble.report.figures.style import BLUE, COLUMN, VERMILION, panels, paper_style
from amble.types import Vector

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def section_distance(distances: Vector, radius: float) -> Figure:
    """Draw the distance on a log axis over the cycles, and the slope that the spectral radius predicts.

    Args:
        distances: distance at the entry of every cycle, (cycles + 1,), with positive values; zeros are not drawn.
        radius: spectral radius of the full cycle.

    Raises:
        InputError: where no distance is positive.
    """
    drawn = np.flatnonzero(distances > 0.0)
    if drawn.size == 0:
        raise InputError("no distance from the fixed point is positive; there is nothing to draw on a log axis")
    with paper_style():
        figure, (axes,) = panels(1, 1, COLUMN, 2.3)
        axes.semilogy(drawn, distances[drawn], ".", markersize=2.5, color=BLUE, label="simulated")
        # the level that round-off keeps the simulation at, where the line may stop
        floor = float(np.median(distances[drawn][-(1 + drawn.size // 2) :]))
        predicted = distances[drawn[0]] * radius ** (drawn - drawn[0]).astype(np.float64)
        shown = predicted >= 0.3 * floor
        axes.semilogy(
            drawn[shown], predicted[shown], "--", color=VERMILION, label=rf"$\rho^k$ with $\rho$ = {radius:.4g}"
        )
        axes.set_xlabel("cycle $k$")
        axes.set_ylabel("distance from the fixed point")
        axes.legend(loc="upper right")
    return figure
