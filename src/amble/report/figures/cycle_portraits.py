"""Phase portraits of the base over many cycles, thinned, coloured by the number of the cycle."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from amble.analysis import Samples
from amble.report.figures.base_portraits import COORDINATES
from amble.report.figures.portrait import axis_labels
from amble.report.figures.style import (
    COLUMN,
    RED,
    panels,
    paper_style,
    plain_number,
    require_matplotlib,
    with_gaps,
)
from amble.types import IntegerVector

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def cycle_portraits(simulated: Samples, shown: int = 24) -> Figure:
    """Draw some of the simulated cycles: the first ones and ever fewer of the later ones, the last on top.

    Args:
        simulated: all cycles.
        shown: about how many cycles to draw.
    """
    require_matplotlib()
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm

    chosen = chosen_cycles(int(simulated.cycles[0]), int(simulated.cycles[-1]), shown)
    with paper_style():
        figure, axes = panels(2, 2, COLUMN, 3.4)
        scale = LogNorm(1.0, max(2.0, float(chosen[-1] - chosen[0] + 1)))
        colours = colormaps["cividis"].reversed()
        for cycle in chosen:
            part = simulated.only(int(cycle), int(cycle) + 1)
            for here, name in zip(axes, COORDINATES, strict=True):
                line = with_gaps(part.segments, *part.coordinate(name))
                here.plot(*line, color=colours(scale(cycle - chosen[0] + 1)), linewidth=0.7)
        for here, name in zip(axes, COORDINATES, strict=True):
            value, rate = simulated.coordinate(name)
            here.plot(value[:1], rate[:1], "o", color=RED, markersize=3.5, zorder=1000)
            horizontal, vertical = axis_labels(name)
            here.set_xlabel(horizontal)
            here.set_ylabel(vertical)
            here.locator_params(axis="x", nbins=3)
            here.xaxis.set_major_formatter(plain_number)
        bar = figure.colorbar(ScalarMappable(scale, colours), ax=axes, label="cycle", location="top", aspect=40)
        bar.ax.xaxis.set_major_formatter("{x:.0f}")
    return figure


def chosen_cycles(first: int, last: int, shown: int) -> IntegerVector:
    """Pick about ``shown`` cycles between two, spaced geometrically from the first, both ends among them."""
    count = last - first + 1
    offsets = np.unique(np.round(np.geomspace(1.0, count, min(shown, count))).astype(np.int64)) - 1
    return first + offsets
