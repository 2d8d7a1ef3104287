"""Orbital stability: multipliers in the complex plane, and the distance of a simulated motion from the fixed point."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from amble.errors import InputError
from amble.report.figures.style import BLUE, GREY, PAGE, VERMILION, legend_above, panels, paper_style
from amble.types import IntegerVector, Vector

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

FloquetMultipliers = NDArray[np.complex128]

LEAST_SHOWN = 10
"""Cycles that the panel of the approach shows at least."""


LARGEST, MOST = 1e100, 200_000
"""Of what is drawn: ticks of matplotlib fail on the largest numbers there are, and a million marks take 15 s."""


def multiplier_circle(before: FloquetMultipliers, after: FloquetMultipliers, figure: Figure | None = None) -> Figure:
    """Draw multipliers with the unit circle: all of them on the left, the neighbourhood of the circle on the right.

    Args:
        before: multipliers of the orbit under the outputs of the gait problem, (n,).
        after: multipliers under the stabilised outputs, (n,).
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        InputError: where there are too many or too large ones to draw.
    """
    _check_drawable(before, "multipliers")
    _check_drawable(after, "multipliers")
    with paper_style():
        figure, (whole, near) = panels(1, 2, PAGE, 3.7, figure=figure)
        for axes in (whole, near):
            _draw_multipliers(axes, before, after)
        reach = 1.15 * max(1.0, float(np.max(np.abs(np.concatenate([before, after])))))
        for axes, limit, title in ((whole, reach, "all multipliers"), (near, 1.25, "near the unit circle")):
            axes.set_xlim(-limit, limit)
            axes.set_ylim(-limit, limit)
            axes.set_title(title)
        outside = int(np.sum(np.maximum(np.abs(before.real), np.abs(before.imag)) > 1.25))
        if outside:
            near.set_title(f"near the unit circle ({outside} of the initial ones lie outside)")
        legend_above(figure, whole, 3)
    return figure


def _draw_multipliers(axes: Axes, before: FloquetMultipliers, after: FloquetMultipliers) -> None:
    angle = np.linspace(0.0, 2.0 * np.pi, 361)
    axes.plot(np.cos(angle), np.sin(angle), color=GREY, linewidth=0.8, label="unit circle")
    for values, colour, marker, label in (
        (before, VERMILION, "x", rf"before, $\rho$ = {_radius(before):.4g}"),
        (after, BLUE, "o", rf"after, $\rho$ = {_radius(after):.4g}"),
    ):
        axes.plot(
            values.real,
            values.imag,
            linestyle="none",
            marker=marker,
            color=colour,
            label=label,
            markersize=4.5,
            fillstyle="none",
        )
    axes.set_aspect("equal")
    axes.set_xlabel(r"Re $\lambda$")
    axes.set_ylabel(r"Im $\lambda$")


def _radius(values: FloquetMultipliers) -> float:
    return float(np.max(np.abs(values)))


def section_distance(distances: Vector, radius: float, figure: Figure | None = None) -> Figure:
    """Draw the distance on a log axis over the cycles, and the slope that the spectral radius predicts.

    All cycles on the left; on the right the approach, up to where the distance no longer falls.

    Args:
        distances: distance at the entry of every cycle, (cycles + 1,), with positive values; zeros are not drawn.
        radius: spectral radius of the full cycle.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        InputError: where no distance is positive, or there are too many or too large ones to draw.
    """
    _check_drawable(distances, "distances from the fixed point")
    drawn = np.flatnonzero(distances > 0.0)
    if drawn.size == 0:
        raise InputError("no distance from the fixed point is positive; there is nothing to draw on a log axis")
    # the level that round-off and the integrator keep the simulation at
    floor = float(np.median(distances[drawn][-(1 + drawn.size // 2) :]))
    arrived = int(drawn[np.argmax(distances[drawn] <= 3.0 * floor)])
    with paper_style():
        figure, (whole, approach) = panels(1, 2, PAGE, 2.4, sharey=True, figure=figure)
        for axes in (whole, approach):
            _draw_distance(axes, distances, drawn, radius, floor)
        approach.set_xlim(-0.5, min(len(distances) - 0.5, max(LEAST_SHOWN, 1.3 * arrived) + 0.5))
        whole.set_ylabel("distance from the fixed point")
        legend_above(figure, whole, 2)
    return figure


def _draw_distance(axes: Axes, distances: Vector, drawn: IntegerVector, radius: float, floor: float) -> None:
    axes.semilogy(drawn, distances[drawn], ".", markersize=3.5, color=BLUE, label="simulated")
    with np.errstate(over="ignore"):
        predicted = distances[drawn[0]] * radius ** (drawn - drawn[0]).astype(np.float64)
    shown = (predicted >= 0.3 * floor) & (predicted <= LARGEST)
    axes.semilogy(drawn[shown], predicted[shown], "--", color=VERMILION, label=rf"$\rho^k$ with $\rho$ = {radius:.4g}")
    axes.set_xlabel("cycle $k$")


def _check_drawable(values: Vector | FloquetMultipliers, what: str) -> None:
    if len(values) > MOST or not np.all(np.abs(values) <= LARGEST):
        raise InputError(f"the {what} cannot be drawn: there are more than {MOST}, or one is above {LARGEST:g}")
