"""Footfall diagram: which foot stands when, over one cycle (paper, figure 4)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from amble.errors import InputError
from amble.hybrid import GaitPattern
from amble.report.figures.style import BLUE, COLUMN, GREY, panels, paper_style, plain_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def footfall(pattern: GaitPattern, durations: Sequence[float], figure: Figure | None = None) -> Figure:
    """Draw a bar for every stance phase of every foot over one cycle.

    Args:
        pattern: the gait pattern.
        durations: of all stances of the cycle, or of the solved half of a mirrored one, s.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        InputError: where the number of durations does not fit the pattern.
    """
    whole = list(durations) * 2 if pattern.mirrored and len(durations) == len(pattern.solved) else list(durations)
    if len(whole) != len(pattern.stances):
        raise InputError(f"{len(durations)} durations do not fit a pattern of {len(pattern.stances)} stances")
    edges = np.concatenate([[0.0], np.cumsum(whole)])
    feet = pattern.robot.foot_names
    with paper_style():
        figure, (axes,) = panels(1, 1, COLUMN, 0.9 + 0.22 * len(feet), figure=figure)
        for row, foot in enumerate(feet):
            for number, stance in enumerate(pattern.stances):
                if foot in stance.feet:
                    axes.barh(row, whole[number], left=edges[number], height=0.62, color=BLUE, linewidth=0.0)
        for edge in edges:
            axes.axvline(edge, color=GREY, linewidth=0.6, linestyle=":")
        axes.set_yticks(range(len(feet)), [plain_text(foot) for foot in feet])
        axes.set_ylim(len(feet) - 0.5, -0.5)
        axes.set_xlim(0.0, edges[-1])
        axes.set_xlabel("time in the cycle (s)")
        axes.set_ylabel("foot on the ground")
        axes.grid(visible=False)
        above = axes.secondary_xaxis("top")
        above.set_xticks(0.5 * (edges[:-1] + edges[1:]), [plain_text(stance.name) for stance in pattern.stances])
        above.tick_params(length=0.0)
    return figure
