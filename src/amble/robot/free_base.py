"""Trajectories in the coordinates of physics engines: a free base as place, quaternion and twist, links as poses."""

from __future__ import annotations

import casadi as ca
import numpy as np
from scipy.spatial.transform import Rotation

from amble.robot import kinematics
from amble.robot.model import Robot
from amble.types import Matrix, NodeValues


def free_base(positions: Matrix, velocities: Matrix) -> tuple[Matrix, Matrix]:
    """Return place and quaternion (w, x, y, z) of the base, (n, 7), and its twist, (n, 6), as MuJoCo's free joint has.

    The twist is the velocity in the world's axes and the angular velocity in the base's. The quaternion's sign is
    continuous. Base angles are those of the chain X-Y-Z.

    Args:
        positions: spatial coordinates (``Base.spatial``), (n, 6 or more).
        velocities: their rates.
    """
    angles = positions[:, 3:6]
    quaternions = continuous(Rotation.from_euler("XYZ", angles).as_quat())[:, [3, 0, 1, 2]]
    cb, sb, cc, sc = np.cos(angles[:, 1]), np.sin(angles[:, 1]), np.cos(angles[:, 2]), np.sin(angles[:, 2])
    roll, pitch, yaw = velocities[:, 3:6].T
    turning = np.column_stack([cc * cb * roll + sc * pitch, -sc * cb * roll + cc * pitch, sb * roll + yaw])
    return np.hstack([positions[:, :3], quaternions]), np.hstack([velocities[:, :3], turning])


def link_trajectories(robot: Robot, positions: Matrix) -> NodeValues:
    """Return origins and quaternions (x, y, z, w) of all links in the world, (n, n_links, 7); signs are continuous."""
    q = ca.SX.sym("q", robot.size)
    s = robot.base.spatial(q)
    base = kinematics.base_rotation(s)
    relative = kinematics.link_poses(robot, s)
    turns = ca.horzcat(*[ca.densify(base @ rotation) for rotation, _ in relative])
    origins = ca.horzcat(*[ca.densify(s[:3] + base @ origin) for _, origin in relative])
    function = ca.Function("poses", [q], [ca.vec(turns), ca.vec(origins)])
    found = function.map(len(positions))(positions.T)
    count = len(robot.links)
    rotations = np.asarray(found[0]).T.reshape(-1, 3, 3).transpose(0, 2, 1)  # casadi stacks columns
    quaternions = continuous(Rotation.from_matrix(rotations).as_quat().reshape(-1, count, 4))
    return np.concatenate([np.asarray(found[1]).T.reshape(-1, count, 3), quaternions], axis=-1)


def continuous(quaternions: NodeValues) -> NodeValues:
    """Give every quaternion the sign that is closer to the one before; along the first axis."""
    flips = np.sum(quaternions[1:] * quaternions[:-1], axis=-1) < 0.0
    signs = np.where(np.cumsum(flips, axis=0) % 2 == 1, -1.0, 1.0)
    return np.concatenate([quaternions[:1], quaternions[1:] * signs[..., None]])
