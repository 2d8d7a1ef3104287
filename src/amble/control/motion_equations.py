"""The motion of a stance whose outputs obey given dynamics: linear equations in accelerations and contact forces.

Nothing inverts the mass matrix. Feet at rest and outputs that obey leave few accelerations open; the base's rows of the
dynamics, in which no actuator appears, and the rows that make the torques the shortest, then give those and the contact
forces; the torques follow from the joints' rows. The allocation law acts afterwards, on the free directions.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.errors import InputError
from amble.hybrid import Contacts
from amble.numerics.linear_algebra import OrthogonalFactor
from amble.robot import dynamics
from amble.robot.coordinate_units import as_torques

SMALLEST_PIVOT = 1e-6
"""Pivots are sines of angles between equations, about 0.1 for ASTRo; below this six digits of the torques are gone."""


@dataclass(frozen=True, kw_only=True)
class MotionEquations:
    """J a = contact, S a - w in the kernel of H, and P (D a - J^T lambda) = load.

    S picks y_a = (roll, pitch, yaw, joints), in the plane (pitch, joints), of the coordinates; P = [I 0; 0 N^T] picks
    the base's rows and sums the joints' rows over every torque N that causes no acceleration.

    Attributes:
        mass: D, (n_q, n_q).
        jacobian: J of the stance feet, (n_f, n_q).
        null_space: orthonormal basis of the kernel of H, (n_a, n_a - n_y).
        rows: P, (6 + k, n_q).
        force_basis: internal contact forces, (n_f, k), N.
        torque_basis: N, the torques that go with them, (n_joints, k), N m.
        closure: factor of the equations that keep the feet at their distances, and from turning about their moments.
        open: accelerations that contacts and outputs leave open, (n_q, d).
        balance: factor of the equations for ``open`` and the contact forces per mass of the robot.
        total: mass of the robot, kg.
        stride: constraint rows of one foot.
        position: coordinates of the base's position.
    """

    mass: ca.SX
    jacobian: ca.SX
    null_space: ca.SX
    rows: ca.SX
    force_basis: ca.SX
    torque_basis: ca.SX
    closure: OrthogonalFactor
    open: ca.SX
    balance: OrthogonalFactor
    total: float
    stride: int
    position: int

    @classmethod
    def of(cls, contacts: Contacts, q: ca.SX, null_space: ca.SX) -> MotionEquations:
        """Write and factor the equations at a configuration.

        Raises:
            InputError: where the stance does not allow exactly as many outputs.
        """
        # shorthand
        robot, stride = contacts.robot, contacts.contact.size
        base, p = robot.base.size, len(robot.base.axes)
        D, J = dynamics.mass_matrix(robot, q), contacts.jacobian(q)
        N, W = contacts.torque_null_space(q)
        outputs, allowed = robot.size - p - null_space.shape[1], len(robot.joints) - N.shape[1]
        if outputs != allowed:
            raise InputError(f"a stance on {len(contacts.feet)} feet takes exactly {allowed} outputs, not {outputs}")

        P = ca.diagcat(ca.SX.eye(base), as_torques(robot, as_torques(robot, N)).T)
        closure = OrthogonalFactor.of(_apart(J[:, p:], stride, p) @ null_space)
        directions = _open_directions(J, null_space, closure.kernel, p)
        balance = OrthogonalFactor.of(ca.horzcat(P @ D @ directions, -robot.mass * (P @ J.T)))
        return cls(
            mass=D,
            jacobian=J,
            null_space=null_space,
            rows=P,
            force_basis=W,
            torque_basis=N,
            closure=closure,
            open=directions,
            balance=balance,
            total=robot.mass,
            stride=stride,
            position=p,
        )

    @property
    def pivots(self) -> ca.SX:
        """Sines of the angles between the equations; the smallest tells when the outputs cannot be decoupled."""
        return ca.vertcat(self.closure.sines, self.balance.sines)

    def solve(self, commanded: ca.SX, contact: ca.SX, load: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return accelerations a, (n_q, m), and contact forces, (n_f, m), one column a case.

        Args:
            commanded: w, (n_a, m).
            contact: accelerations of the stance feet, (n_f, m).
            load: right side of the rows P, (6 + k, m).
        """
        # shorthand
        J, Z, p = self.jacobian, self.null_space, self.position

        moved = contact - J[:, p:] @ commanded
        outputs = commanded + Z @ self.closure.solve(_apart(moved, self.stride, p))
        one = ca.vertcat(_common(contact - J[:, p:] @ outputs, p), outputs)
        found = self.balance.solve(load - self.rows @ (self.mass @ one))
        count = self.open.shape[1]
        return one + self.open @ found[:count, :], self.total * found[count:, :]


def _apart(rows: ca.SX, stride: int, position: int) -> ca.SX:
    """What remains of the rows when the base's position is free.

    The velocity of every foot but the first, less that of the first, and all angular velocities.
    """
    kept = [ca.SX(0, rows.shape[1])]
    for start in range(0, rows.shape[0], stride):
        if start:
            kept.append(rows[start : start + position, :] - rows[:position, :])
        kept.append(rows[start + position : start + stride, :])
    return ca.vertcat(*kept)


def _common(rows: ca.SX, position: int) -> ca.SX:
    """Velocity rows of the first foot, which the base's position follows; zero without a foot."""
    return rows[:position, :] if rows.shape[0] else ca.SX(position, rows.shape[1])


def _open_directions(jacobian: ca.SX, null_space: ca.SX, kernel: ca.SX, position: int) -> ca.SX:
    """Accelerations that move no foot and no output; without feet the base's position is open too."""
    outputs = null_space @ kernel
    if jacobian.shape[0]:
        return ca.vertcat(-_common(jacobian[:, position:] @ outputs, position), outputs)
    return ca.diagcat(ca.SX.eye(position), outputs)
