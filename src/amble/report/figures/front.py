"""Torque against robustness: a point a gait, and the line of those that no other one beats."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from amble.errors import InputError
from amble.report.figures.style import BLUE, COLUMN, VERMILION, panels, paper_style, plain_text

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def torque_push(
    torques: Sequence[float],
    pushes: Sequence[float],
    names: Sequence[str],
    best: Sequence[bool],
    figure: Figure | None = None,
) -> Figure:
    """Draw the push that gaits bear over the torque that they take.

    Args:
        torques: RMS torque of every gait, N m.
        pushes: impulse that it bears, N s.
        names: of the gaits; those on the front are written beside their points.
        best: whether a gait is on the front.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        InputError: there is no gait.
    """
    if not torques:
        raise InputError("a front needs gaits")
    points = sorted(zip(torques, pushes, names, best, strict=True))
    with paper_style():
        figure, (axes,) = panels(1, 1, COLUMN, 2.6, figure=figure)
        others = [point for point in points if not point[3]]
        chosen = [point for point in points if point[3]]
        axes.plot([p[0] for p in others], [p[1] for p in others], "x", color=VERMILION, label="another is better")
        axes.step([p[0] for p in chosen], [p[1] for p in chosen], where="post", marker="o", color=BLUE, label="front")
        for torque, push, name, _ in chosen:
            axes.annotate(
                plain_text(name), (torque, push), textcoords="offset points", xytext=(4, -9), fontsize="xx-small"
            )
        axes.set_xlabel("RMS torque (N m)")
        axes.set_ylabel("push that half of all directions\nand phases bear (N s)")
        axes.margins(x=0.12, y=0.1)
        if others:
            axes.legend()
    return figure
