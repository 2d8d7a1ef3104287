"""One phase portrait: a coordinate against its rate, optimised and simulated, initial values as red dots."""

from __future__ import annotations

from typing import TYPE_CHECKING

from amble.analysis import Samples
from amble.report.figures.style import BLUE, ORANGE, RED, plain_text, with_gaps

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SYMBOLS = {"x": "x", "y": "y", "z": "z", "roll": r"\phi", "pitch": r"\theta", "yaw": r"\psi"}


def axis_labels(name: str) -> tuple[str, str]:
    """Label of a coordinate and of its rate, with units."""
    if name in ("x", "y", "z"):
        return f"${name}$ (m)", rf"$\dot{{{name}}}$ (m/s)"
    if name in SYMBOLS:
        return f"{name} ${SYMBOLS[name]}$ (rad)", rf"$\dot{{{SYMBOLS[name]}}}$ (rad/s)"
    return f"{plain_text(name.replace('_', ' '))} (rad)", "rate (rad/s)"


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
    horizontal, vertical = axis_labels(name)
    axes.set_xlabel(horizontal)
    axes.set_ylabel(vertical)
