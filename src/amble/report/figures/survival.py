"""Survival curves: which share of the walks is still upright after how many cycles."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from amble.errors import InputError
from amble.report.figures.style import (
    COLUMN,
    LAW_COLOURS,
    LAW_STYLES,
    legend_above,
    panels,
    paper_style,
    plain_text,
)

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def survival(walks: Mapping[str, Sequence[int]], cycles: int, figure: Figure | None = None) -> Figure:
    """Draw a curve a group of walks: the share that completed at least k cycles, over k (Kaplan-Meier's estimate).

    Every walk ends at a fall or after ``cycles``, so nothing is censored earlier and the share is the estimate.

    Args:
        walks: group, such as the size of a disturbance -> completed cycles of each of its walks.
        cycles: how many each walk was asked for.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        InputError: there is no group, a group is empty, or a walk completed more cycles than were asked for.
    """
    if not walks or not all(len(completed) for completed in walks.values()):
        raise InputError("a survival curve needs groups of walks, each with at least one")
    counted = {name: np.asarray(completed, dtype=np.int64) for name, completed in walks.items()}
    for name, completed in counted.items():
        if completed.min() < 0 or completed.max() > cycles:
            raise InputError(
                f"walks of group '{name}' completed {completed.min()} to {completed.max()} of {cycles} cycles"
            )
    places = np.arange(cycles + 1)
    with paper_style():
        figure, (axes,) = panels(1, 1, COLUMN, 2.2, figure=figure)
        for number, (name, completed) in enumerate(counted.items()):
            share = np.mean(completed[np.newaxis, :] >= places[:, np.newaxis], axis=1)
            axes.step(
                places,
                100.0 * share,
                where="post",
                color=LAW_COLOURS[number % len(LAW_COLOURS)],
                linestyle=LAW_STYLES[number % len(LAW_STYLES)],
                label=f"{plain_text(name)} ({len(completed)})",
            )
        axes.set_xlim(0, cycles)
        axes.set_ylim(-3.0, 103.0)
        axes.set_xlabel("completed cycles")
        axes.set_ylabel("walks still upright (%)")
        legend_above(figure, axes, 3)
    return figure
