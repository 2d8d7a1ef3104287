"""Contact forces that move nothing: the null space of the grasp map (docs/theory/allocation.md, eq. 4)."""

from __future__ import annotations

from itertools import combinations

import casadi as ca

from amble.errors import InputError
from amble.hybrid import stance_jacobian
from amble.numerics.linear_algebra import SymmetricFactor
from amble.robot import Robot, kinematics


def torque_null_space(robot: Robot, feet: tuple[str, ...], q: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the torques that cause no acceleration, (n_joints, k), and the internal forces that go with them.

    D a + h = B u + J^T lambda stays as it is where W s is added to lambda and -J_joints^T W s to u.

    Args:
        robot: the robot.
        feet: the stance feet.
        q: coordinates, (n_q,).

    Returns:
        N = -J_joints^T W, N m, and W of ``internal_forces``, (3 n_c, k), N.
    """
    joints = len(robot.joints)
    force_basis = internal_forces(ca.vertcat(*[kinematics.foot_position(robot, foot, q) for foot in feet], ca.SX(0, 1)))
    if force_basis.shape[1] == 0:
        return ca.SX(joints, 0), force_basis
    return -stance_jacobian(robot, feet, q)[:, robot.size - joints :].T @ force_basis, force_basis


def internal_forces(positions: ca.SX) -> ca.SX:
    """Return W (3 n_c, k): a basis of the contact forces with zero net force and moment, k = 0, 1, 3, 6.

    Two and three feet: squeezes [e; -e] along the lines between the feet. Four feet: the squeezes of the first
    three, and for each axis a unit force at the fourth foot with the smallest forces of the first three that balance
    it; the six squeezes alone would lose one direction where four feet lie on a plane. The feet must not coincide,
    and three of them must not lie on a line.

    Args:
        positions: stance feet in the world frame, (3 n_c,), m.

    Raises:
        InputError: more than four stance feet.
    """
    feet = [positions[3 * i : 3 * i + 3] for i in range(positions.shape[0] // 3)]
    if len(feet) > 4:
        raise InputError(f"internal forces are known for up to four stance feet, not {len(feet)}")
    columns = [_squeeze(feet, a, b) for a, b in combinations(range(min(len(feet), 3)), 2)]
    if len(feet) == 4:
        columns.append(_balance(feet))
    return ca.horzcat(*columns) if columns else ca.SX(3 * len(feet), 0)


def _squeeze(feet: list[ca.SX], a: int, b: int) -> ca.SX:
    """Opposite forces of feet a and b along the line between them, proportional to its length."""
    column = ca.SX.zeros(3 * len(feet))
    line = feet[b] - feet[a]
    column[3 * a : 3 * a + 3] = line
    column[3 * b : 3 * b + 3] = -line
    return column


def _balance(feet: list[ca.SX]) -> ca.SX:
    """Unit forces at the fourth foot, balanced by the first three: (12, 3)."""
    three = ca.horzcat(*[_grasp(foot - feet[3]) for foot in feet[:3]])
    fourth = _grasp(ca.SX.zeros(3))
    answer = -three.T @ SymmetricFactor.of(three @ three.T).solve(fourth)
    return ca.vertcat(answer, ca.SX.eye(3))


def _grasp(arm: ca.SX) -> ca.SX:
    """Force and moment about the reference of a force at the end of the arm: (6, 3)."""
    return ca.vertcat(ca.SX.eye(3), ca.skew(arm))
