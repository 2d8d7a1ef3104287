"""Phase portraits: a coordinate against its rate, optimised and simulated (paper, figures 2, 3) or over many cycles."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from amble.analysis import Samples
from amble.report.figures.style import (
    BLUE,
    COLUMN,
    ORANGE,
    PAGE,
    RED,
    legend_above,
    panels,
    paper_style,
    plain_number,
    plain_text,
    require_matplotlib,
    with_gaps,
)
from amble.robot import Robot
from amble.robot.coordinate_units import unit_of
from amble.types import IntegerVector

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SYMBOLS = {"x": "x", "y": "y", "z": "z", "roll": r"\phi", "pitch": r"\theta", "yaw": r"\psi"}

COORDINATES = ("z", "roll", "pitch", "yaw")
"""x and y are no orbits, by design."""


def axis_labels(name: str, unit: str = "rad") -> tuple[str, str]:
    """Label of a coordinate and of its rate, with units; that of a joint is given."""
    if name in ("x", "y", "z"):
        return f"${name}$ (m)", rf"$\dot{{{name}}}$ (m/s)"
    if name in SYMBOLS:
        return f"{name} ${SYMBOLS[name]}$ (rad)", rf"$\dot{{{SYMBOLS[name]}}}$ (rad/s)"
    return f"{plain_text(name.replace('_', ' '))} ({unit})", f"rate ({unit}/s)"


def draw_portrait(axes: Axes, name: str, optimised: Samples, simulated: Samples) -> None:
    """Draw one coordinate of both motions against its rate; jumps at impacts are gaps.

    Args:
        axes: where to draw.
        name: the coordinate.
        optimised: the gait, drawn as a broad line.
        simulated: the closed loop, drawn dashed on top.
    """
    for samples, colour, style, width, label in (
        (optimised, BLUE, "-", 2.0, "optimised"),
        (simulated, ORANGE, "--", 1.0, "simulated"),
    ):
        value, rate = samples.coordinate(name)
        axes.plot(
            *with_gaps(samples.segments, value, rate), color=colour, linestyle=style, linewidth=width, label=label
        )
    value, rate = simulated.coordinate(name)
    axes.plot(value[:1], rate[:1], "o", color=RED, markersize=3.5, label="initial value", zorder=5)
    horizontal, vertical = axis_labels(name, unit_of(optimised.robot, name))
    axes.set_xlabel(horizontal)
    axes.set_ylabel(vertical)


def base_portraits(optimised: Samples, simulated: Samples, figure: Figure | None = None) -> Figure:
    """Draw the base coordinates that repeat against their rates.

    Args:
        optimised: whole cycles of the gait.
        simulated: cycles of the closed loop.
        figure: an empty one to draw into, of any size; a new one by default.
    """
    with paper_style():
        figure, axes = panels(2, 2, COLUMN, 3.2, figure=figure)
        for each, name in _drawn(axes, optimised.robot):
            draw_portrait(each, name, optimised, simulated)
            each.locator_params(axis="x", nbins=3)
            each.xaxis.set_major_formatter(plain_number)
        legend_above(figure, axes[0], 3)
    return figure


def _drawn(axes: Sequence[Axes], robot: Robot) -> list[tuple[Axes, str]]:
    """Where each of the coordinates that a robot has is drawn; the other axes are switched off."""
    names = [name for name in COORDINATES if name in robot.base.coordinates]
    for empty in axes[len(names) :]:
        empty.set_axis_off()
    return list(zip(axes, names, strict=False))


def joint_portraits(optimised: Samples, simulated: Samples, figure: Figure | None = None) -> Figure:
    """Draw every joint of every leg against its rate.

    Args:
        optimised: whole cycles of the gait.
        simulated: cycles of the closed loop.
        figure: an empty one to draw into, of any size; a new one by default.
    """
    legs = list(optimised.robot.legs.values())
    with paper_style():
        columns = max(len(leg) for leg in legs)
        figure, axes = panels(len(legs), columns, PAGE, 0.4 + 1.45 * len(legs), figure=figure)
        for row, leg in enumerate(legs):
            for column in range(columns):
                here = axes[row * columns + column]
                if column < len(leg):
                    draw_portrait(here, leg[column], optimised, simulated)
                else:
                    here.set_axis_off()
        legend_above(figure, axes[0], 3)
    return figure


def cycle_portraits(simulated: Samples, shown: int = 24, figure: Figure | None = None) -> Figure:
    """Draw some of the simulated cycles: the first ones and ever fewer of the later ones, the last on top.

    Args:
        simulated: all cycles.
        shown: about how many cycles to draw.
        figure: an empty one to draw into, of any size; a new one by default.
    """
    require_matplotlib()
    from matplotlib import colormaps
    from matplotlib.cm import ScalarMappable
    from matplotlib.colors import LogNorm

    chosen = chosen_cycles(int(simulated.cycles[0]), int(simulated.cycles[-1]), shown)
    with paper_style():
        figure, axes = panels(2, 2, COLUMN, 3.4, figure=figure)
        scale = LogNorm(1.0, max(2.0, float(chosen[-1] - chosen[0] + 1)))
        colours = colormaps["cividis"].reversed()
        places = _drawn(axes, simulated.robot)
        for cycle in chosen:
            part = simulated.only(int(cycle), int(cycle) + 1)
            for here, name in places:
                line = with_gaps(part.segments, *part.coordinate(name))
                here.plot(*line, color=colours(scale(cycle - chosen[0] + 1)), linewidth=0.7)
        for here, name in places:
            value, rate = simulated.coordinate(name)
            here.plot(value[:1], rate[:1], "o", color=RED, markersize=3.5, zorder=1000)
            horizontal, vertical = axis_labels(name, unit_of(simulated.robot, name))
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
