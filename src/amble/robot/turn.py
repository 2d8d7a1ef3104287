"""A robot turned about the vertical: what a turn does to coordinates and rates, whatever the base's angles.

The base angles turn about the axes of the serial x-y-z chain, so a turn about the world's vertical axis changes all
three of them. The angular velocity in base axes, E(angles) rates, stays what it is.
"""

from __future__ import annotations

import casadi as ca
import numpy as np

from amble.robot.kinematics import angle_axes, base_rotation
from amble.robot.rotation import rotation_about
from amble.types import NodeValues

VERTICAL = np.array([0.0, 0.0, 1.0])
BASE, ANGLES = slice(0, 3), slice(3, 6)


def turn_error(q: ca.SX, turned: ca.SX, angle: ca.SX) -> ca.SX:
    """Return the axis of the rotation from one orientation, turned by an angle, to another, times its sine, (3,).

    Zero where ``turned`` has the orientation of q after a turn about the vertical.

    Args:
        q: coordinates before the turn, (n_q,).
        turned: coordinates after it, (n_q,).
        angle: of the turn, rad.
    """
    apart = base_rotation(turned).T @ rotation_about(VERTICAL, angle) @ base_rotation(q)
    return ca.inv_skew(0.5 * (apart - apart.T))


def turned_velocity(q: ca.SX, v: ca.SX, turned: ca.SX, angle: ca.SX) -> ca.SX:
    """Return rates after a turn about the vertical, (n_q,).

    Args:
        q: coordinates before the turn, (n_q,).
        v: their rates, (n_q,).
        turned: coordinates after it, (n_q,).
        angle: of the turn, rad.
    """
    linear = rotation_about(VERTICAL, angle) @ v[BASE]
    angular = ca.inv(angle_axes(turned)) @ angle_axes(q) @ v[ANGLES]
    return ca.vertcat(linear, angular, v[ANGLES.stop :])


def turned_state(x: ca.SX, angle: float | ca.SX) -> ca.SX:
    """Write a state turned about the vertical through the origin; yaw goes on continuously from where it was, (2 n_q,).

    Args:
        x: coordinates and their rates, (2 n_q,).
        angle: of the turn, rad.
    """
    q, v = ca.vertsplit(x, x.numel() // 2)
    R = rotation_about(VERTICAL, angle) @ base_rotation(q)
    near, yaw = q[5] + angle, ca.atan2(-R[0, 1], R[0, 0])
    there = ca.vertcat(
        rotation_about(VERTICAL, angle) @ q[BASE],
        ca.atan2(-R[1, 2], R[2, 2]),
        ca.asin(R[0, 2]),
        near + ca.atan2(ca.sin(yaw - near), ca.cos(yaw - near)),
        q[ANGLES.stop :],
    )
    return ca.vertcat(there, turned_velocity(q, v, there, angle))


def turned(q: NodeValues, v: NodeValues, angle: float) -> tuple[NodeValues, NodeValues]:
    """Turn states about the vertical through the origin; yaw goes on continuously from where it was.

    Args:
        q: coordinates, (n, n_q).
        v: their rates, (n, n_q).
        angle: of the turn, rad.
    """
    about = np.asarray(rotation_about(VERTICAL, angle))
    there, rates = np.array(q), np.array(v)
    there[:, BASE], rates[:, BASE] = q[:, BASE] @ about.T, v[:, BASE] @ about.T
    for row in range(len(q)):
        R = about @ np.asarray(base_rotation(q[row]))
        yaw = np.arctan2(-R[0, 1], R[0, 0])
        near = q[row, 5] + angle
        yaw += 2.0 * np.pi * np.round((near - yaw) / (2.0 * np.pi))
        there[row, ANGLES] = np.arctan2(-R[1, 2], R[2, 2]), np.arcsin(np.clip(R[0, 2], -1.0, 1.0)), yaw
        before, after = (np.asarray(angle_axes(place[row])) for place in (q, there))
        rates[row, ANGLES] = np.linalg.solve(after, before @ v[row, ANGLES])
    return there, rates
