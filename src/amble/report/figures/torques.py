"""Torques over time for several allocation laws on the same motion (paper, figure 5)."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import numpy as np

from amble.analysis import Motion
from amble.errors import UnknownNameError
from amble.report.figures.style import (
    LAW_COLOURS,
    LAW_LABELS,
    LAW_STYLES,
    PAGE,
    legend_above,
    panels,
    paper_style,
    plain_text,
    with_gaps,
)
from amble.robot import Robot

if TYPE_CHECKING:
    from matplotlib.figure import Figure


def left_joints(robot: Robot) -> tuple[str, ...]:
    """Joints of the left legs, leg by leg: of the first foot of every left-right pair."""
    return tuple(joint for left, _ in robot.twins for joint in robot.legs[left])


def torque_magnitudes(motion: Motion, joints: Sequence[str], columns: int = 3, figure: Figure | None = None) -> Figure:
    """Draw |torque| of some joints over time, one panel a joint, one line a law.

    Args:
        motion: the motion with the torques of its laws; the paper shows two consecutive cycles.
        joints: names of the joints.
        columns: panels beside each other.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        UnknownNameError: where the motion has no such joint.
    """
    return _panels(motion, joints, columns, magnitude=True, figure=figure)


def torque_lines(motion: Motion, joints: Sequence[str], columns: int = 3, figure: Figure | None = None) -> Figure:
    """Draw the signed torque of some joints over time, one panel a joint, one line a law.

    Args:
        motion: the motion with the torques of its laws, such as one cycle.
        joints: names of the joints.
        columns: panels beside each other.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        UnknownNameError: where the motion has no such joint.
    """
    return _panels(motion, joints, columns, magnitude=False, figure=figure)


def _panels(motion: Motion, joints: Sequence[str], columns: int, magnitude: bool, figure: Figure | None) -> Figure:
    for joint in joints:
        if joint not in motion.joints:
            raise UnknownNameError("joint", joint, motion.joints)
    rows = -(-len(joints) // columns)
    time = motion.times - motion.times[0]
    with paper_style():
        figure, axes = panels(rows, columns, PAGE, 0.5 + 1.45 * rows, sharex=True, figure=figure)
        for number, joint in enumerate(joints):
            here = axes[number]
            for style, (law, torque) in enumerate(motion.torques.items()):
                values = torque[:, motion.joints.index(joint)]
                here.plot(
                    *with_gaps(motion.segments, time, np.abs(values) if magnitude else values),
                    color=LAW_COLOURS[style % len(LAW_COLOURS)],
                    linestyle=LAW_STYLES[style % len(LAW_STYLES)],
                    label=plain_text(LAW_LABELS.get(law, law)),
                )
            here.set_title(plain_text(joint.replace("_", " ")))
            here.set_xlim(0.0, time[-1])
            if magnitude:
                here.set_ylim(bottom=0.0)
            if number % columns == 0:
                here.set_ylabel(r"$|\tau|$ (N m)" if magnitude else r"$\tau$ (N m)")
            if number >= len(joints) - columns:
                here.set_xlabel("time (s)")
        for empty in axes[len(joints) :]:
            empty.set_axis_off()
        legend_above(figure, axes[0], min(len(motion.torques), 4))
    return figure
