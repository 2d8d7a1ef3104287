"""Figures of robustness: how many pushed walks go on, and what the linearisation predicts of that."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING

import numpy as np

from amble.analysis.proportions import wilson
from amble.report.figures.style import (
    COLUMN,
    LAW_COLOURS,
    LAW_STYLES,
    PAGE,
    legend_above,
    panels,
    paper_style,
    plain_text,
    require_matplotlib,
)

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

BINS = 12
"""Ranges of impulses of a survival curve, as many trials in each."""

SMALLEST_BIN = 10


def push_survival(trials: Mapping[str, tuple[Sequence[float], Sequence[bool]]], figure: Figure | None = None) -> Figure:
    """Draw a curve a group of trials: the share that walks on over the impulse, with Wilson's intervals of 95 %.

    Args:
        trials: group -> impulse of each trial, N s, and whether it was survived.
        figure: an empty one to draw into, of any size; a new one by default.
    """
    with paper_style():
        figure, (axes,) = panels(1, 1, COLUMN, 2.4, figure=figure)
        for number, (name, (impulses, survived)) in enumerate(trials.items()):
            size, share, low, high = survival_bins(impulses, survived)
            colour = LAW_COLOURS[number % len(LAW_COLOURS)]
            axes.plot(
                size,
                100.0 * share,
                color=colour,
                linestyle=LAW_STYLES[number % len(LAW_STYLES)],
                marker="o",
                markersize=3.0,
                label=f"{plain_text(name)} ({len(impulses)})",
            )
            axes.fill_between(size, 100.0 * low, 100.0 * high, color=colour, alpha=0.2, linewidth=0.0)
        axes.set_xscale("log")
        axes.set_ylim(-3.0, 103.0)
        axes.set_xlabel("impulse of the push (N s)")
        axes.set_ylabel("walks that go on (%)")
        legend_above(figure, axes, 3)
    return figure


def survival_bins(impulses: Sequence[float], survived: Sequence[bool]) -> tuple[np.ndarray, ...]:
    """Return mean impulse, share, and both ends of its interval in ranges of as many trials each, (k,) each."""
    order = np.argsort(impulses, kind="stable")
    count = max(1, min(BINS, len(order) // SMALLEST_BIN))
    found = []
    for rows in np.array_split(order, count):
        lived = int(np.sum(np.asarray(survived)[rows]))
        found.append((float(np.mean(np.asarray(impulses)[rows])), lived / len(rows), *wilson(lived, len(rows))))
    return tuple(np.array(found).T)


def _logarithmic(panel: Axes) -> None:
    """Scale both axes by powers, with plain numbers at 1, 2 and 5: thresholds seldom span more than two decades."""
    require_matplotlib()
    from matplotlib.ticker import FuncFormatter, LogLocator, NullFormatter

    panel.set_xscale("log")
    panel.set_yscale("log")
    for axis in (panel.xaxis, panel.yaxis):
        axis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axis.set_minor_formatter(NullFormatter())


def predicted_measured(
    groups: Mapping[str, tuple[Sequence[float], Sequence[float]]], labels: Sequence[str], figure: Figure | None = None
) -> Figure:
    """Draw measured over predicted thresholds, one panel a group, both on logarithmic axes.

    Args:
        groups: title -> predicted and measured, of the same length; those measured at 0 are left out.
        labels: of both axes.
        figure: an empty one to draw into, of any size; a new one by default.
    """
    columns = max(1, (len(groups) + 1) // 2) if len(groups) > 2 else len(groups)
    rows = -(-len(groups) // columns)
    with paper_style():
        figure, axes = panels(rows, columns, PAGE if columns > 1 else COLUMN, 2.3 * rows, figure=figure)
        for panel, (title, (predicted, measured)) in zip(axes, groups.items(), strict=False):
            pairs = np.array([pair for pair in zip(predicted, measured, strict=True) if min(pair) > 0.0]).reshape(-1, 2)
            panel.scatter(pairs[:, 0], pairs[:, 1], s=9.0, color=LAW_COLOURS[0], label=plain_text(title))
            if pairs.size:  # nothing has no logarithm
                _logarithmic(panel)
            else:
                panel.text(0.5, 0.5, "no threshold measured", ha="center", transform=panel.transAxes)
                panel.set(xticks=(), yticks=())
            panel.set_title(plain_text(title))
            panel.set_xlabel(labels[0])
            panel.set_ylabel(labels[1])
        for panel in axes[len(groups) :]:
            panel.set_visible(False)
    return figure
