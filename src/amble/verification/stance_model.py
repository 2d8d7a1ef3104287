"""A robot on some of its feet, as numbers: the equations of motion at many states, solved as dense linear systems.

This is the check's own path: no factorisation written as expressions, no elimination of the contact forces, no closed
form of internal forces. What the gait problem and the controller compute by those must agree with it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.control import AllocationLaw, Redundancy
from amble.errors import WorkError
from amble.robot import Robot, dynamics, kinematics
from amble.types import Matrix

Stack = NDArray[np.float64]
"""(points, rows, columns): a matrix at every point."""

INTERNAL = {0: 0, 1: 0, 2: 1, 3: 3, 4: 6}
"""Number of stance feet -> directions of internal force (docs/theory/hybrid-model.md, eq. 10)."""


@dataclass(frozen=True, kw_only=True)
class Terms:
    """The terms of D a + h = B u + J^T lambda and J a + Jdot v = 0 at many states.

    Attributes:
        robot: the robot.
        feet: the stance feet, in the robot's foot order.
        velocities: v, (points, n_q).
        mass: D, (points, n_q, n_q).
        bias: h, (points, n_q).
        jacobian: J of the stance feet, (points, 3 n_c, n_q).
        contact_bias: Jdot v, (points, 3 n_c).
        positions: of all feet, world frame, (points, 3 n_feet), m.
        rates: velocities of all feet, world frame, (points, 3 n_feet), m/s.
    """

    robot: Robot
    feet: tuple[str, ...]
    velocities: Matrix
    mass: Stack
    bias: Matrix
    jacobian: Stack
    contact_bias: Matrix
    positions: Matrix
    rates: Matrix

    @cached_property
    def force_basis(self) -> Stack:
        """Contact forces with zero net force and moment on the base, orthonormal, (points, 3 n_c, k)."""
        count = INTERNAL[len(self.feet)]
        grasp = np.swapaxes(self.jacobian[:, :, :6], 1, 2)  # base rows of J^T
        right = np.linalg.svd(grasp, full_matrices=True)[2]
        return np.swapaxes(right[:, right.shape[1] - count :, :], 1, 2)

    @cached_property
    def torque_basis(self) -> Stack:
        """Torques that cause no acceleration, -(leg rows of J^T) W, (points, n_joints, k)."""
        return -np.swapaxes(self.jacobian[:, :, 6:], 1, 2) @ self.force_basis

    def foot(self, name: str) -> slice:
        """Columns of a foot in ``positions`` and ``rates``."""
        place = 3 * self.robot.foot_names.index(name)
        return slice(place, place + 3)


@dataclass(frozen=True)
class Motion:
    """Accelerations, torques and contact forces at many states: (points, n_q), (points, n_joints), (points, 3 n_c)."""

    accelerations: Matrix
    torques: Matrix
    forces: Matrix


def terms(robot: Robot, feet: Sequence[str], q: Matrix, v: Matrix) -> Terms:
    """Evaluate all terms at states (q, v), (points, n_q) each."""
    points, size, feet_size = len(q), robot.size, 3 * len(robot.feet)
    values = _terms(robot).map(points)(q.T, v.T)
    mass, bias, jacobian, contact_bias, positions = (np.asarray(value) for value in values)
    rows = [3 * robot.foot_names.index(foot) + axis for foot in feet for axis in range(3)]
    stacked = jacobian.reshape(feet_size, points, size).transpose(1, 0, 2)
    return Terms(
        robot=robot,
        feet=tuple(feet),
        velocities=v,
        mass=mass.reshape(size, points, size).transpose(1, 0, 2),
        bias=bias.T,
        jacobian=stacked[:, rows],
        contact_bias=contact_bias.T[:, rows],
        positions=positions.T,
        rates=np.einsum("pij,pj->pi", stacked, v),
    )


@lru_cache(maxsize=16)
def _terms(robot: Robot) -> ca.Function:
    q, v = ca.SX.sym("q", robot.size), ca.SX.sym("v", robot.size)
    names = robot.foot_names
    parts = [
        dynamics.mass_matrix(robot, q),
        dynamics.bias(robot, q, v),
        ca.vertcat(*[kinematics.foot_jacobian(robot, name, q) for name in names]),
        ca.vertcat(*[kinematics.foot_bias(robot, name, q, v) for name in names]),
        ca.vertcat(*[kinematics.foot_position(robot, name, q) for name in names]),
    ]
    return ca.Function("terms", [q, v], [ca.densify(part) for part in parts], {"cse": True})


def smallest_torques(at: Terms, weights: Matrix, commanded: Matrix) -> Motion:
    """Solve the motion in which the weighted outputs accelerate as commanded, with the smallest torques.

    Unknowns (a, u, lambda) of [D -B -J^T; J 0 0; H S 0 0; 0 N^T 0], solved as one dense system.

    Args:
        at: the terms.
        weights: H over (roll, pitch, yaw, joints), (n_y, n_q - 3).
        commanded: w with H (a - w) = 0, (points, n_q - 3).

    Raises:
        WorkError: the system is singular: the decoupling matrix has lost rank.
    """
    # shorthand
    D, J, N, H = at.mass, at.jacobian, at.torque_basis, weights
    points, n, m, c, y, k = len(D), D.shape[1], N.shape[1], J.shape[1], len(H), N.shape[2]
    system = np.zeros((points, n + c + y + k, n + m + c))
    right = np.zeros((points, n + c + y + k))
    system[:, :n, :n] = D
    system[:, n - m : n, n : n + m] = -np.eye(m)
    system[:, :n, n + m :] = -np.swapaxes(J, 1, 2)
    system[:, n : n + c, :n] = J
    system[:, n + c : n + c + y, 3:n] = H
    system[:, n + c + y :, n : n + m] = np.swapaxes(N, 1, 2)
    right[:, :n], right[:, n : n + c] = -at.bias, -at.contact_bias
    right[:, n + c : n + c + y] = commanded @ H.T
    try:
        solution = np.linalg.solve(system, right[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        raise WorkError(f"the outputs of stance {', '.join(at.feet)} lose their rank along the motion") from None
    return Motion(solution[:, :n], solution[:, n : n + m], solution[:, n + m :])


def allocated(at: Terms, motion: Motion, law: AllocationLaw) -> Motion:
    """Move the smallest torques along the internal forces to where the law wants them."""
    if at.torque_basis.shape[2] == 0:
        return motion
    chosen = _through_law(at, motion, law, "allocate")
    torques = motion.torques + np.einsum("pij,pj->pi", at.torque_basis, chosen)
    forces = motion.forces + np.einsum("pij,pj->pi", at.force_basis, chosen)
    return Motion(motion.accelerations, torques, forces)


def law_residuals(at: Terms, torques: Matrix, forces: Matrix, law: AllocationLaw) -> Matrix:
    """Evaluate the rows of the law at given torques and forces, (points, k)."""
    return _through_law(at, Motion(np.zeros_like(at.bias), torques, forces), law, "optimality_conditions")


def _through_law(at: Terms, motion: Motion, law: AllocationLaw, method: str) -> Matrix:
    """Evaluate ``law.allocate`` or ``law.optimality_conditions`` at numbers."""
    points, joints, k = at.torque_basis.shape
    contacts = at.force_basis.shape[1]
    standing = ca.DM(joints, k)  # only torques of stance legs can change; a law may read that from the pattern of N
    standing[[at.robot.joint_index(joint) for foot in at.feet for joint in at.robot.legs[foot]], :] = 1.0
    u, N = ca.SX.sym("u", joints), ca.SX.sym("N", standing.sparsity())
    lam, W, speeds = ca.SX.sym("lambda", contacts), ca.SX.sym("W", contacts, k), ca.SX.sym("speeds", joints)
    redundancy = Redundancy(
        robot=at.robot, feet=at.feet, torques=u, torque_basis=N, forces=lam, force_basis=W, speeds=speeds
    )
    function = ca.Function("law", [u, N, lam, W, speeds], [ca.densify(getattr(law, method)(redundancy))])
    values = function.map(points)(
        motion.torques.T,
        at.torque_basis.transpose(1, 0, 2).reshape(joints, points * k),
        motion.forces.T,
        at.force_basis.transpose(1, 0, 2).reshape(contacts, points * k),
        at.velocities[:, 6:].T,
    )
    return np.asarray(values).T.reshape(points, -1)
