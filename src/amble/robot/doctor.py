"""What of a robot cannot work or is hardly meant, one sentence each, before a solver spends a minute on it."""

from __future__ import annotations

import numpy as np

from amble.errors import InputError
from amble.robot.kinematics import foot_position, link_pose
from amble.robot.mirror import find_mirror
from amble.robot.model import Robot

SHORTEST_RADIUS = 2e-3
"""Smallest radius of gyration of a link, sqrt(largest principal moment / mass), as a share of the robot's reach; the
links of thirteen real robots have 0.022 to 0.35."""


def doubts(robot: Robot) -> tuple[str, ...]:
    """Return what is odd about a robot: joints that cannot move, inertias of another unit."""
    return (*_ranges(robot), *_inertias(robot))


def asymmetry(robot: Robot) -> str | None:
    """Return why a gait that mirrors left and right is out of reach of a robot with feet; None where it is not."""
    try:
        find_mirror(robot)
    except InputError as error:
        return str(error)
    return None


def reach(robot: Robot) -> float:
    """Return the largest distance from the base to a joint or foot at the zero pose, plus the leg length, m.

    No part of the robot is further from any other than twice that.
    """
    zero = np.zeros(robot.size)
    origins = [np.asarray(link_pose(robot, joint.child, zero)[1]).ravel() for joint in robot.joints]
    feet = [np.asarray(foot_position(robot, foot, zero)).ravel() for foot in robot.foot_names]
    return max(float(np.linalg.norm(place)) for place in (*origins, *feet)) + robot.leg_length


def _ranges(robot: Robot) -> list[str]:
    return [
        f"joint '{joint.name}' cannot move: its range is {joint.lower:g} to {joint.upper:g} rad"
        for joint in robot.joints
        if not joint.lower < joint.upper
    ]


def _inertias(robot: Robot) -> list[str]:
    """A solid within the robot's reach r has moments of at most m r^2; one of its size has a radius not far below."""
    most = reach(robot)
    found = []
    for link in robot.links:
        radius = float(np.sqrt(max(np.linalg.eigvalsh(link.inertia)[-1], 0.0) / link.mass))
        if radius > most:
            found.append(
                f"link '{link.name}' ({link.mass:g} kg) has the inertia of a body of {radius:.2g} m radius, but "
                f"nothing of the robot reaches beyond {most:.2g} m; are its moments in kg m^2?"
            )
        elif radius < SHORTEST_RADIUS * most:
            found.append(
                f"link '{link.name}' ({link.mass:g} kg) has the inertia of a body of {1e3 * radius:.2g} mm radius in a "
                f"robot that reaches {most:.2g} m; are its moments in kg m^2?"
            )
    return found
