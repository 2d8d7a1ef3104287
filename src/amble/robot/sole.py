"""The lowest point of a round foot: a point foot below the frame that a file calls its foot."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.errors import InputError
from amble.robot.kinematics import link_pose
from amble.robot.model import Robot
from amble.robot.proposal import standing_posture
from amble.types import frozen


def lowered(robot: Robot, radius: float) -> Robot:
    """Return the robot with its point feet moved down by a radius, as it stands by default.

    The point is fixed in its link: that a sphere rolls on the ground is left out.

    Args:
        robot: the robot, its feet at the centres of the spheres.
        radius: m.

    Raises:
        InputError: the radius is not positive, or no posture is known (``standing_posture``).
    """
    if not 0.0 < radius < robot.leg_length:
        raise InputError(f"the foot_radius is {radius:g} m; it must be positive and less than a leg")
    q = standing_posture(robot).coordinates(robot)
    feet = []
    for foot in robot.feet:
        rotation = np.asarray(link_pose(robot, foot.link, q)[0])
        feet.append(replace(foot, offset=frozen(foot.offset - radius * rotation[2])))
    return replace(robot, feet=tuple(feet))
