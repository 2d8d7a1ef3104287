"""Phase portraits of the base: height, roll, pitch and yaw, optimised against simulated (paper, figure 2)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from amble.analysis import Samples
from amble.report.figures.portrait import draw_portrait
from amble.report.figures.style import COLUMN, legend_above, panels, paper_style, plain_number

if TYPE_CHECKING:
    from matplotlib.figure import Figure

COORDINATES = ("z", "roll", "pitch", "yaw")
"""x and y are no orbits, by design."""


def base_portraits(optimised: Samples, simulated: Samples) -> Figure:
    """Draw the base coordinates that repeat against their rates.

    Args:
        optimised: whole cycles of the gait.
        simulated: cycles of the closed loop.
    """
    with paper_style():
        figure, axes = panels(2, 2, COLUMN, 3.2)
        for each, name in zip(axes, COORDINATES, strict=True):
            draw_portrait(each, name, optimised, simulated)
            each.locator_params(axis="x", nbins=3)
            each.xaxis.set_major_formatter(plain_number)
        legend_above(figure, axes[0], 3)
    return figure
