"""Motors: torque against speed with their limits, and the power of every joint."""

from __future__ import annotations

from collections.abc import Sequence
from math import isfinite
from typing import TYPE_CHECKING

import numpy as np

from amble.analysis import Motion
from amble.control.actuator import Actuator
from amble.errors import UnknownNameError
from amble.report.figures.style import (
    GREY,
    LAW_COLOURS,
    LAW_LABELS,
    LAW_STYLES,
    PAGE,
    VERMILION,
    legend_above,
    panels,
    paper_style,
    plain_text,
    with_gaps,
)
from amble.robot import Robot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

COLUMNS = 3


def torque_speed(motion: Motion, robot: Robot, joints: Sequence[str], figure: Figure | None = None) -> Figure:
    """Draw the torque of some joints against their speed, one line a law, inside the limits of the robot's file.

    Args:
        motion: the motion with the torques of its laws.
        robot: whose limits are drawn; a joint without limits has no box.
        joints: names of the joints, one panel each.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        UnknownNameError: where the motion has no such joint.
    """
    rows = -(-len(joints) // COLUMNS)
    with paper_style():
        figure, axes = panels(rows, COLUMNS, PAGE, 0.5 + 1.7 * rows, figure=figure)
        for number, name in enumerate(joints):
            here, column = axes[number], _column(motion, name)
            for style, (law, torque) in enumerate(motion.torques.items()):
                here.plot(
                    *with_gaps(motion.segments, motion.speeds[:, column], torque[:, column]),
                    color=LAW_COLOURS[style % len(LAW_COLOURS)],
                    linestyle=LAW_STYLES[style % len(LAW_STYLES)],
                    label=plain_text(LAW_LABELS.get(law, law)),
                )
            _limits(here, robot, name)
            here.set_title(plain_text(name.replace("_", " ")))
            if number % COLUMNS == 0:
                here.set_ylabel(r"$\tau$ (N m)")
            if number >= len(joints) - COLUMNS:
                here.set_xlabel("speed (rad/s)")
        for empty in axes[len(joints) :]:
            empty.set_axis_off()
        legend_above(figure, axes[0], min(len(motion.torques), 4))
    return figure


def joint_power(motion: Motion, law: str, actuator: Actuator, figure: Figure | None = None) -> Figure:
    """Draw the mean mechanical power and heat of every joint over a motion, as stacked bars.

    Args:
        motion: the motion.
        law: which of its torques.
        actuator: the motor.
        figure: an empty one to draw into, of any size; a new one by default.

    Raises:
        UnknownNameError: where the motion holds no torques of that law, or has no joint that the motor names.
    """
    torque = motion.torque(law)
    mechanical = _mean(motion, actuator.mechanical(torque, motion.speeds))
    heat = _mean(motion, actuator.heat(torque, motion.joints))
    places = np.arange(len(motion.joints))
    with paper_style():
        figure, (axes,) = panels(1, 1, PAGE, 2.4, figure=figure)
        axes.bar(places, mechanical, color=LAW_COLOURS[0], label="mechanical, without recuperation")
        axes.bar(places, heat, bottom=mechanical, color=VERMILION, label=f"heat (motor '{plain_text(actuator.name)}')")
        axes.set_xticks(places, [plain_text(name.replace("_", " ")) for name in motion.joints], rotation=45, ha="right")
        axes.set_ylabel("mean power (W)")
        axes.grid(visible=False, axis="x")
        legend_above(figure, axes, 2)
    return figure


def _column(motion: Motion, joint: str) -> int:
    if joint not in motion.joints:
        raise UnknownNameError("joint", joint, motion.joints)
    return motion.joints.index(joint)


def _limits(axes: Axes, robot: Robot, name: str) -> None:
    """Mark the limits of a joint that the motion comes near: the view stays with the motion."""
    joint, arm = robot.joint(name), float(robot.torque_arms[robot.joint_index(name)])
    low, high, left, right = *axes.get_ylim(), *axes.get_xlim()
    for sign in (-1.0, 1.0):
        if isfinite(joint.effort) and low <= sign * joint.effort * arm <= high:
            axes.axhline(sign * joint.effort * arm, color=GREY, linewidth=0.8, linestyle=":")
        if isfinite(joint.velocity) and left <= sign * joint.velocity / arm <= right:
            axes.axvline(sign * joint.velocity / arm, color=GREY, linewidth=0.8, linestyle=":")


def _mean(motion: Motion, power: np.ndarray) -> np.ndarray:
    """Mean over time of every column, by trapezia that cross no event, W."""
    steps = np.where(np.diff(motion.segments) == 0, np.diff(motion.times), 0.0)
    return 0.5 * steps @ (power[1:] + power[:-1]) / motion.duration
