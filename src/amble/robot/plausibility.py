"""Whether a robot can work: what its equations of motion take for granted, as rows, and what is hardly meant."""

from __future__ import annotations

import numpy as np

from amble.errors import InputError
from amble.residual import Residual
from amble.robot.dynamics import mass_matrix
from amble.robot.kinematics import zero_poses
from amble.robot.mirror import find_mirror
from amble.robot.model import Robot
from amble.types import Vector

SMALLEST_SHARE = 1e-9
"""Smallest eigenvalue of the mass matrix with a unit diagonal; less is singular to double precision."""

LARGEST_ASYMMETRY = 1e-6
"""Largest relative asymmetry at which one half of a cycle may speak for the other; an exact model has about 1e-15."""

POSES = 20
"""Random poses at which the mass matrix is looked at, besides the zero pose."""

SHORTEST_RADIUS = 2e-3
"""Smallest radius of gyration of a link, sqrt(largest principal moment / mass), as a share of the robot's reach; the
links of thirteen real robots have 0.022 to 0.35."""


def physical_rows(robot: Robot, mirrored: bool) -> tuple[Residual, ...]:
    """Return what equations of motion take for granted beyond what every ``Robot`` holds: mass matrix and symmetry.

    An inertia that breaks the triangle inequality belongs to no body but gives sound equations of motion; it passes.

    Args:
        robot: the robot.
        mirrored: whether its left-right mirror is used; its own ``symmetry_tolerance`` does not count here.
    """
    rows = [Residual("smallest eigenvalue of the scaled mass matrix", SMALLEST_SHARE, smallest_share(robot), np.inf)]
    if mirrored:
        rows.append(Residual("left-right asymmetry of the robot", 0.0, robot.mirror.asymmetry, LARGEST_ASYMMETRY))
    return tuple(rows)


def smallest_share(robot: Robot) -> float:
    """Return the smallest eigenvalue over the poses of D scaled to a unit diagonal; NaN where that is impossible."""
    drawn = np.random.default_rng(0).uniform(-1.0, 1.0, (POSES, robot.size))
    drawn[:, : robot.base.size] = (
        0.0  # D does not depend on the position; Euler angles, not the robot, degrade it with orientation
    )
    shares = [_share(robot, pose) for pose in (np.zeros(robot.size), *drawn)]
    return float(np.min(shares))  # NaN where any is


def _share(robot: Robot, pose: Vector) -> float:
    inertia = np.asarray(mass_matrix(robot, pose))
    diagonal = np.diag(inertia)
    if not (np.all(np.isfinite(inertia)) and np.all(diagonal > 0.0)):
        return float("nan")
    root = np.sqrt(diagonal)
    return float(np.linalg.eigvalsh(inertia / np.outer(root, root))[0])


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
    poses = zero_poses(robot)
    feet = [poses[foot.link][1] + poses[foot.link][0] @ foot.offset for foot in robot.feet]
    return max(float(np.linalg.norm(place)) for place in (*(at for _, at in poses), *feet)) + robot.leg_length


def _ranges(robot: Robot) -> list[str]:
    return [
        f"joint '{joint.name}' cannot move: its range is {joint.lower:g} to {joint.upper:g} {joint.unit}"
        for joint in robot.joints
        if not joint.lower < joint.upper
    ]


def _inertias(robot: Robot) -> list[str]:
    """A solid within the robot's reach r has moments of at most m r^2; one of its size has a radius not far below."""
    most = reach(robot)
    found = []
    for link in robot.links:
        if not (link.mass > 0.0 and np.any(link.inertia)):
            continue  # the cross between two joints: its mass matrix was looked at when it was loaded
        radius = float(np.sqrt(max(np.linalg.eigvalsh(link.inertia)[-1], 0.0)) / np.sqrt(link.mass))  # no overflow
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
