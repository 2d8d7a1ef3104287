"""A mirrored gait of a robot that is nearly symmetric: left and right inertias are averaged, and that is said."""

from __future__ import annotations

import logging
from collections.abc import Callable

from amble.errors import printable
from amble.hybrid import GaitPattern
from amble.robot import Robot, symmetrized
from amble.robot.mirror import AsymmetryError

logger = logging.getLogger("amble")

LARGEST_AVERAGED = 0.05
"""Largest relative asymmetry that is averaged unasked; real files have 1e-4 to 0.2."""


def on_symmetric(robot: Robot, build: Callable[[Robot], GaitPattern], symmetrize: bool | None = None) -> GaitPattern:
    """Build the pattern of a robot; where its mirror needs that, of the robot with left and right averaged.

    Args:
        robot: the robot.
        build: the pattern of a robot.
        symmetrize: whether left and right are averaged; by default only where the gait is mirrored and the robot
            deviates by more than its tolerance and at most ``LARGEST_AVERAGED``, with a notice.

    Raises:
        AsymmetryError: the robot is not as symmetric as the gait.
        InputError: what ``build`` raises.
    """
    if symmetrize:
        return build(symmetrized(robot))
    try:
        return build(robot)
    except AsymmetryError as error:
        if symmetrize is not None or error.geometry or error.asymmetry > LARGEST_AVERAGED:
            raise
        logger.warning(
            "%s: %s differs by %.2g of its size from left to right; left and right inertias are averaged",
            printable(robot.name),
            error.what,
            error.asymmetry,
        )
        return build(symmetrized(robot))
