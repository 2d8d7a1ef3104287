"""Phase portraits of the joints, one row a leg, optimised against simulated (paper, figure 3)."""

from __future__ import annotations

from typing import TYPE_CHECKING

from amble.analysis import Samples
from amble.report.figures.portrait import draw_portrait
from amble.report.figures.style import PAGE, legend_above, panels, paper_style

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def joint_portraits(optimised: Samples, simulated: Samples) -> Figure:
    """Draw every joint of every leg against its rate.

    Args:
        optimised: whole cycles of the gait.
        simulated: cycles of the closed loop.
    """
    legs = list(optimised.robot.legs.values())
    with paper_style():
        columns = max(len(leg) for leg in legs)
        figure, axes = panels(len(legs), columns, PAGE, 0.4 + 1.45 * len(legs))
        for row, leg in enumerate(legs):
            for column in range(columns):
                here = axes[row * columns + column]
                if column < len(leg):
                    draw_portrait(here, leg[column], optimised, simulated)
                else:
                    here.set_axis_off()
        legend_above(figure, axes[0], 3)
    return figure
