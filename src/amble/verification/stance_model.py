"""A robot on some of its feet, as numbers: the equations of motion at many states, solved as dense linear systems.

This is the check's own path: no factorisation written as expressions, no elimination of the contact forces, no closed
form of internal forces. What the gait problem and the controller compute by those must agree with it.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property, lru_cache

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from amble.control import AllocationLaw, Redundancy
from amble.errors import WorkError
from amble.hybrid import Contacts
from amble.hybrid.contact import AXES
from amble.hybrid.ground import into_frame
from amble.robot import dynamics
from amble.types import Matrix, Vector

Stack = NDArray[np.float64]
"""(points, rows, columns): a matrix at every point."""


@dataclass(frozen=True, kw_only=True)
class Terms:
    """The terms of D a + h = B u + J^T lambda and J a + Jdot v = 0 at many states.

    Attributes:
        contacts: the stance feet on the ground, with the robot.
        velocities: v, (points, n_q).
        mass: D, (points, n_q, n_q).
        bias: h, (points, n_q).
        jacobian: J of the stance feet, (points, n_f, n_q).
        contact_bias: Jdot v, (points, n_f).
        positions: of all feet, world frame, (points, 3 n_feet), m.
        rates: velocities of all feet, world frame, (points, 3 n_feet), m/s.
    """

    contacts: Contacts
    velocities: Matrix
    mass: Stack
    bias: Matrix
    jacobian: Stack
    contact_bias: Matrix
    positions: Matrix
    rates: Matrix

    @cached_property
    def force_basis(self) -> Stack:
        """Contact forces with zero net force and moment on the base, orthonormal, (points, n_f, k)."""
        count = self.contacts.internal_force_count
        grasp = np.swapaxes(self.jacobian[:, :, : self.contacts.robot.base.size], 1, 2)  # base rows of J^T
        right = np.linalg.svd(grasp, full_matrices=True)[2]
        return np.swapaxes(right[:, right.shape[1] - count :, :], 1, 2)

    @cached_property
    def torque_basis(self) -> Stack:
        """Torques that cause no acceleration, -(leg rows of J^T) W, (points, n_joints, k)."""
        return -np.swapaxes(self.jacobian[:, :, self.contacts.robot.base.size :], 1, 2) @ self.force_basis

    def foot(self, name: str) -> slice:
        """Columns of a foot in ``positions`` and ``rates``."""
        place = 3 * self.contacts.robot.foot_names.index(name)
        return slice(place, place + 3)

    def gap(self, name: str) -> Vector:
        """Signed distance of a foot from the ground along its normal, (points,), m."""
        gap: Vector = self.contacts.ground.gap(self.positions[:, self.foot(name)])
        return gap

    def local_velocity(self, name: str) -> Matrix:
        """Velocity of a foot along the ground's two tangents and its normal there, (points, 3), m/s."""
        columns = self.foot(name)
        velocity: Matrix = into_frame(self.rates[:, columns], self.contacts.ground.frame(self.positions[:, columns]))
        return velocity

    def local_force(self, name: str, forces: Matrix) -> Matrix:
        """Contact force of a stance foot in the ground's frame there, (points, size), of all, (points, n_f)."""
        frame = self.contacts.ground.frame(self.positions[:, self.foot(name)])
        local: Matrix = self.contacts.contact.local(forces[:, self.contacts.slice(name)], frame)
        return local


@dataclass(frozen=True)
class Motion:
    """Accelerations, torques and contact forces at many states: (points, n_q), (points, n_joints), (points, n_f)."""

    accelerations: Matrix
    torques: Matrix
    forces: Matrix


def terms(contacts: Contacts, q: Matrix, v: Matrix) -> Terms:
    """Evaluate all terms at states (q, v), (points, n_q) each."""
    points, size, all_feet = len(q), contacts.robot.size, contacts.every_foot
    values = _terms(all_feet).map(points)(q.T, v.T)
    mass, bias, jacobian, contact_bias, positions = (np.asarray(value) for value in values)
    rows = contacts.columns
    stacked = jacobian.reshape(all_feet.size, points, size).transpose(1, 0, 2)
    axes, count = list(all_feet.contact.axes), len(all_feet.feet)
    translation = [all_feet.slice(foot).start + row for foot in all_feet.feet for row in range(len(axes))]
    rates = np.zeros((points, count, len(AXES)))
    rates[:, :, axes] = np.einsum("pij,pj->pi", stacked[:, translation], v).reshape(points, count, len(axes))
    return Terms(
        contacts=contacts,
        velocities=v,
        mass=mass.reshape(size, points, size).transpose(1, 0, 2),
        bias=bias.T,
        jacobian=stacked[:, rows],
        contact_bias=contact_bias.T[:, rows],
        positions=positions.T,
        rates=rates.reshape(points, -1),
    )


@lru_cache(maxsize=16)
def _terms(contacts: Contacts) -> ca.Function:
    robot = contacts.robot
    q, v = ca.SX.sym("q", robot.size), ca.SX.sym("v", robot.size)
    parts = [
        dynamics.mass_matrix(robot, q),
        dynamics.bias(robot, q, v),
        contacts.jacobian(q),
        contacts.bias(q, v),
        contacts.points(q),
    ]
    return ca.Function("terms", [q, v], [ca.densify(part) for part in parts], {"cse": True})


def smallest_torques(at: Terms, rows: Stack, commanded: Matrix) -> Motion:
    """Solve the motion in which the outputs accelerate as commanded, with the smallest torques.

    Unknowns (a, u, lambda) of [D -B -J^T; J 0 0; Y 0 0; 0 N^T 0], solved as one dense system; forces of
    prismatic joints count as torques (``Robot.torque_arms``).

    Args:
        at: the terms.
        rows: Y, the outputs' accelerations by the coordinates', (points, n_y, n_q).
        commanded: Y a, (points, n_y).

    Raises:
        WorkError: the system is singular: the decoupling matrix has lost rank.
    """
    # shorthand
    D, J, N = at.mass, at.jacobian, at.torque_basis
    points, n, m, c, y, k = len(D), D.shape[1], N.shape[1], J.shape[1], rows.shape[1], N.shape[2]
    system = np.zeros((points, n + c + y + k, n + m + c))
    right = np.zeros((points, n + c + y + k))
    system[:, :n, :n] = D
    system[:, n - m : n, n : n + m] = -np.eye(m)
    system[:, :n, n + m :] = -np.swapaxes(J, 1, 2)
    system[:, n : n + c, :n] = J
    system[:, n + c : n + c + y, :n] = rows
    system[:, n + c + y :, n : n + m] = np.swapaxes(N, 1, 2) * at.contacts.robot.torque_arms**2
    right[:, :n], right[:, n : n + c] = -at.bias, -at.contact_bias
    right[:, n + c : n + c + y] = commanded
    try:
        solution = np.linalg.solve(system, right[:, :, None])[:, :, 0]
    except np.linalg.LinAlgError:
        feet = ", ".join(at.contacts.feet)
        raise WorkError(f"the outputs of stance {feet} lose their rank along the motion") from None
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
    contacts, robot = at.contacts, at.contacts.robot
    if not k:
        return np.zeros((points, 0))  # nothing to choose, as in flight
    standing = ca.DM(joints, k)  # only torques of stance legs can change; a law may read that from the pattern of N
    standing[[robot.joint_index(joint) for foot in contacts.feet for joint in robot.legs[foot]], :] = 1.0
    u, N = ca.SX.sym("u", joints), ca.SX.sym("N", standing.sparsity())
    lam, W, speeds = ca.SX.sym("lambda", contacts.size), ca.SX.sym("W", contacts.size, k), ca.SX.sym("speeds", joints)
    places = ca.SX.sym("p", len(AXES) * len(contacts.feet))
    redundancy = Redundancy(
        contacts=contacts,
        points=places,
        torques=u,
        torque_basis=N,
        forces=lam,
        force_basis=W,
        speeds=speeds,
    )
    arms = robot.torque_arms
    function = ca.Function("law", [u, N, lam, W, speeds, places], [ca.densify(getattr(law, method)(redundancy))])
    values = function.map(points)(
        (arms * motion.torques).T,
        (arms[:, None] * at.torque_basis).transpose(1, 0, 2).reshape(joints, points * k),
        motion.forces.T,
        at.force_basis.transpose(1, 0, 2).reshape(contacts.size, points * k),
        (at.velocities[:, robot.base.size :] / arms).T,
        np.hstack([at.positions[:, at.foot(foot)] for foot in contacts.feet]).T,
    )
    return np.asarray(values).T.reshape(points, -1)
