"""Making a nearly symmetric robot exactly symmetric, so that half a gait determines the other half."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.robot.kinematics import link_pose
from amble.robot.mirror import REFLECTION, partners
from amble.robot.model import Link, Robot
from amble.types import Matrix, Vector, frozen


def symmetrized(robot: Robot) -> Robot:
    """Return the robot with every link's mass, centre and inertia averaged with its twin's mirror image.

    Real models differ by a part in a thousand from left to right. Geometry is left as it is: where joints or feet are
    not symmetric, ``Robot.mirror`` of the result still says so.

    Raises:
        InputError: where feet have no twins, or joints do not pair.
    """
    partner = partners(robot)
    twin = [0, *(partner[j] + 1 for j in range(len(robot.joints)))]
    poses = [_at_zero(robot, link) for link in range(len(robot.links))]
    links = tuple(
        _mean(link, _reflected(robot.links[twin[i]], poses[twin[i]], poses[i])) for i, link in enumerate(robot.links)
    )
    return replace(robot, links=links)


def _at_zero(robot: Robot, link: int) -> tuple[Matrix, Vector]:
    rotation, origin = link_pose(robot, link, np.zeros(robot.size))
    return np.asarray(rotation), np.asarray(origin).ravel()


def _reflected(link: Link, of: tuple[Matrix, Vector], into: tuple[Matrix, Vector]) -> Link:
    """Mirror a link at the zero pose and express it in its twin's frame."""
    turn = into[0].T @ REFLECTION @ of[0]
    center = turn @ link.center + into[0].T @ (REFLECTION @ of[1] - into[1])
    return Link(link.name, link.mass, frozen(center), frozen(turn @ link.inertia @ turn.T))


def _mean(link: Link, image: Link) -> Link:
    return Link(
        link.name,
        (link.mass + image.mass) / 2.0,
        frozen((link.center + image.center) / 2.0),
        frozen((link.inertia + image.inertia) / 2.0),
    )
