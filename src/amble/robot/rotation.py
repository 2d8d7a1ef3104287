"""Rotations: numeric ones from files, symbolic ones about a fixed axis."""

from __future__ import annotations

from typing import Any

import casadi as ca
import numpy as np

from amble.types import Matrix, Vector

ROUND_OFF = 1e-12
"""Direction cosines this close to 0, 1 or -1 are taken as exact: files write pi with 12 digits."""


def snap(directions: Matrix) -> Matrix:
    """Round direction cosines within ``ROUND_OFF`` of 0, 1 or -1, so that symbolic products keep their zeros."""
    nearest = np.round(directions)
    return np.where(np.abs(directions - nearest) < ROUND_OFF, nearest + 0.0, directions)


def rotation_of_rpy(angles: Vector) -> Matrix:
    """Return Rz(yaw) Ry(pitch) Rx(roll), the convention of URDF for fixed frames (not the one of the base)."""
    if not np.any(angles):
        return np.eye(3)
    (sr, sp, sy), (cr, cp, cy) = np.sin(angles), np.cos(angles)
    about_x = np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    about_y = np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    about_z = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]])
    return snap(about_z @ about_y @ about_x)


def rotation_about(axis: Vector, angle: Any) -> Any:
    """Return the rotation matrix about a unit vector: a a' + cos (I - a a') + sin [a]x (Rodrigues), (3, 3)."""
    axis = snap(axis)
    outer = np.outer(axis, axis)
    return constant(outer) + ca.cos(angle) * constant(np.eye(3) - outer) + ca.sin(angle) * constant(skew(axis))


def skew(vector: Vector) -> Matrix:
    """Return the matrix [a] of the cross product: [a] b = a x b."""
    x, y, z = vector
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def constant(values: Matrix) -> ca.DM:
    """Return a casadi constant whose zeros are structural."""
    return ca.sparsify(ca.DM(np.asarray(values, dtype=np.float64)))


def cross(a: ca.SX | ca.DM, b: ca.SX | ca.DM) -> ca.SX:
    """Return a x b; products with structural zeros vanish."""
    return ca.vertcat(a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0])
