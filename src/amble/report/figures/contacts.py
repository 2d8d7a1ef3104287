"""Feet: where they go, and with which forces they push, beside the cone that holds them."""

from __future__ import annotations

from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from amble.analysis import Samples
from amble.report.figures.style import (
    BLUE,
    COLUMN,
    GREY,
    PAGE,
    VERMILION,
    legend_above,
    panels,
    paper_style,
    plain_text,
    with_gaps,
)
from amble.types import NodeValues

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def foot_paths(samples: Samples, figure: Figure | None = None) -> Figure:
    """Draw the path of every foot over the ground, seen from the side: forward relative to the base, height.

    Args:
        samples: the motion; one cycle shows each path once.
        figure: an empty one to draw into, of any size; a new one by default.
    """
    points = _foot_points(samples)
    gaps = samples.pattern.ground.gap(points)
    forward = points[:, :, 0] - samples.positions[:, 0:1]
    with paper_style():
        figure, (axes,) = panels(1, 1, COLUMN, 2.2, figure=figure)
        for number, foot in enumerate(samples.robot.foot_names):
            colour = f"C{number % 10}"
            axes.plot(
                *with_gaps(samples.segments, forward[:, number], 1e3 * np.asarray(gaps)[:, number]),
                color=colour,
                label=plain_text(foot),
            )
        axes.axhline(0.0, color=GREY, linewidth=0.6, linestyle=":")
        axes.set_xlabel("forward of the base's origin (m)")
        axes.set_ylabel("height over the ground (mm)")
        legend_above(figure, axes, min(len(samples.robot.foot_names), 4))
    return figure


def contact_forces(samples: Samples, figure: Figure | None = None) -> Figure:
    """Draw every foot's normal force, its tangential force, and what the cone allows of that, over time.

    Args:
        samples: the motion.
        figure: an empty one to draw into, of any size; a new one by default.
    """
    local = samples.local_forces(samples.forces)
    contact = samples.pattern.contact
    normal, tangential = contact.normal_force(local), contact.tangential(local)
    allowed = samples.pattern.ground.friction * normal
    time = samples.times - samples.times[0]
    feet = samples.robot.foot_names
    columns = min(len(feet), 2)
    rows = -(-len(feet) // columns)
    with paper_style():
        figure, axes = panels(rows, columns, PAGE, 0.5 + 1.5 * rows, sharex=True, sharey=True, figure=figure)
        for number, foot in enumerate(feet):
            here = axes[number]
            for values, colour, style, label in (
                (normal, BLUE, "-", "normal force"),
                (allowed, GREY, ":", "what the cone allows"),
                (tangential, VERMILION, "--", "tangential force"),
            ):
                here.plot(
                    *with_gaps(samples.segments, time, values[:, number]), color=colour, linestyle=style, label=label
                )
            here.set_title(plain_text(foot))
            here.set_xlim(0.0, time[-1])
            if number % columns == 0:
                here.set_ylabel("force (N)")
            if number >= len(feet) - columns:
                here.set_xlabel("time (s)")
        for empty in axes[len(feet) :]:
            empty.set_axis_off()
        legend_above(figure, axes[0], 3)
    return figure


def _foot_points(samples: Samples) -> NodeValues:
    """Positions of all feet, (n, n_feet, 3), m."""
    q = ca.SX.sym("q", samples.robot.size)
    function = ca.Function("points", [q], [samples.pattern.all_contacts.points(q)])
    return np.asarray(function.map(len(samples.times))(samples.positions.T)).T.reshape(len(samples.times), -1, 3)
