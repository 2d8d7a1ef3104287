"""A number of many gaits over the axes of their library; gaits that failed are crosses."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from amble.errors import InputError
from amble.report.figures.style import BLUE, COLUMN, PAGE, VERMILION, panels, paper_style, plain_text

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

ACROSS = 3
"""Panels side by side."""


def gait_map(
    points: Sequence[Mapping[str, float]],
    numbers: Sequence[float | None],
    quantity: str,
    units: Mapping[str, str],
    figure: Figure | None = None,
) -> Figure:
    """Draw a number over one or two axes; of more, a panel for every value of the others.

    The two axes with the most values are those of the panels.

    Args:
        points: axis -> value, of every gait; the same axes of all.
        numbers: the number of every gait; None where it failed.
        quantity: what the number is.
        units: axis -> unit.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        InputError: there is no gait.
    """
    if not points:
        raise InputError("a map needs gaits")
    counts = {name: len({point[name] for point in points}) for name in points[0]}
    inside = sorted(counts, key=lambda name: -counts[name])[:2]
    inside = [name for name in points[0] if name in inside]
    others = [name for name in points[0] if name not in inside]
    groups: dict[tuple[float, ...], list[int]] = {}
    for number, point in enumerate(points):
        groups.setdefault(tuple(point[name] for name in others), []).append(number)
    across = min(ACROSS, len(groups))
    down = -(-len(groups) // across)
    width = COLUMN if across == 1 else PAGE
    with paper_style():
        figure, axes = panels(down, across, width, 2.4 * down, figure=figure)
        values = np.array([np.nan if number is None else number for number in numbers])
        for panel in axes[len(groups) :]:
            panel.set_visible(False)
        shown = None
        for panel, (at, members) in zip(axes, sorted(groups.items()), strict=False):
            chosen = [points[number] for number in members]
            if len(inside) == 1:
                _line(panel, inside[0], chosen, values[members])
                panel.set_ylabel(quantity)
            else:
                shown = _grid(panel, inside, chosen, values[members], values) or shown
                panel.set_ylabel(_axis(inside[1], units))
            panel.set_xlabel(_axis(inside[0], units))
            panel.set_title(
                ", ".join(f"{_word(name)} {value:g} {units[name]}" for name, value in zip(others, at, strict=True))
            )
        if shown is not None:
            figure.colorbar(shown, ax=axes[: len(groups)], label=plain_text(quantity))
    return figure


def _line(panel: Axes, name: str, points: Sequence[Mapping[str, float]], values: np.ndarray) -> None:
    order = np.argsort([point[name] for point in points])
    x, y = np.array([point[name] for point in points])[order], values[order]
    panel.plot(x, y, "o-", color=BLUE, markersize=3.0)
    failed = np.isnan(y)
    low = float(np.nanmin(y)) if not failed.all() else 0.0
    panel.plot(x[failed], np.full(int(failed.sum()), low), "x", color=VERMILION, markersize=4.0)


def _grid(
    panel: Axes, names: Sequence[str], points: Sequence[Mapping[str, float]], values: np.ndarray, every: np.ndarray
) -> Any:
    """Squares of colour, the same scale in all panels."""
    x, y = (np.array([point[name] for point in points]) for name in names)
    failed = np.isnan(values)
    panel.plot(x[failed], y[failed], "x", color=VERMILION, markersize=4.0)
    if np.isnan(every).all():
        return None
    columns, rows = np.unique(x), np.unique(y)
    table = np.full((len(rows), len(columns)), np.nan)
    table[np.searchsorted(rows, y), np.searchsorted(columns, x)] = values
    panel.grid(False)
    return panel.pcolormesh(
        columns,
        rows,
        table,
        shading="nearest",
        cmap="viridis",
        vmin=float(np.nanmin(every)),
        vmax=float(np.nanmax(every)),
    )


def _axis(name: str, units: Mapping[str, str]) -> str:
    return f"{_word(name)} ({units[name]})" if units[name] != "1" else _word(name)


def _word(name: str) -> str:
    return name.replace("_", " ")
