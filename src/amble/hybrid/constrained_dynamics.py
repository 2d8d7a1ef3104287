"""The motion of a robot whose feet neither slip nor sink, and the plastic impact when feet land (paper, section 2)."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.hybrid.contacts import Contacts
from amble.numerics.linear_algebra import SymmetricFactor
from amble.robot import Robot, dynamics


@dataclass(frozen=True, kw_only=True)
class ConstrainedDynamics:
    """The motion of a robot that stands on some feet, affine in the torques.

    With D a + h = B u + J^T lambda and J a + Jdot v = 0 (paper, eq. 2):
    a = free_acceleration + input_map u, lambda = free_force + force_map u.

    Attributes:
        free_acceleration: f0, (n_q,).
        input_map: G, (n_q, n_joints).
        free_force: lambda at zero torque, (n_f,), N and N m.
        force_map: d lambda / d u, (n_f, n_joints).
        jacobian: J of the stance feet, (n_f, n_q).
        positions: stance feet, world frame, (3 n_c,), m.
    """

    free_acceleration: ca.SX
    input_map: ca.SX
    free_force: ca.SX
    force_map: ca.SX
    jacobian: ca.SX
    positions: ca.SX


def selection(robot: Robot) -> ca.SX:
    """Return the actuation matrix B = [0; I], (n_q, n_joints)."""
    joints = len(robot.joints)
    return ca.SX(ca.vertcat(ca.DM(robot.size - joints, joints), ca.DM.eye(joints)))


@dataclass(frozen=True, kw_only=True)
class StandingEquations:
    """The factored equations D a - J^T lambda = F, J a = c of a robot whose feet stand.

    Attributes:
        mass: factor of D.
        jacobian: J, (n_f, n_q).
        moved: D^-1 J^T, (n_q, n_f).
        apparent: factor of J D^-1 J^T, the inverse of the mass seen at the feet; None without feet.
    """

    mass: SymmetricFactor
    jacobian: ca.SX
    moved: ca.SX
    apparent: SymmetricFactor | None

    @classmethod
    def of(cls, contacts: Contacts, q: ca.SX) -> StandingEquations:
        """Factor the equations at a configuration."""
        robot = contacts.robot
        D = SymmetricFactor.of(dynamics.mass_matrix(robot, q), _elimination_order(robot))
        J = contacts.jacobian(q)
        Y = D.solve(J.T) if contacts.feet else ca.SX(robot.size, 0)
        return cls(mass=D, jacobian=J, moved=Y, apparent=SymmetricFactor.of(J @ Y) if contacts.feet else None)

    def solve(self, force: ca.SX, contact: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return a, (n_q, m), and lambda, (n_f, m), one column a right side.

        Args:
            force: F, (n_q, m).
            contact: c, (n_f, m).
        """
        free = self.mass.solve(force)
        if self.apparent is None:
            return free, ca.SX(0, force.shape[1])
        forces = self.apparent.solve(contact - self.jacobian @ free)
        return free + self.moved @ forces, forces


def constrained_dynamics(contacts: Contacts, q: ca.SX, v: ca.SX) -> ConstrainedDynamics:
    """Eliminate the contact forces (paper, eq. 2 and 3)."""
    # shorthand
    robot, equations = contacts.robot, StandingEquations.of(contacts, q)
    B, Jdv = selection(robot), contacts.bias(q, v)

    free_acceleration, free_force = equations.solve(-dynamics.bias(robot, q, v), -Jdv)
    input_map, force_map = equations.solve(B, ca.SX(Jdv.shape[0], B.shape[1]))
    return ConstrainedDynamics(
        free_acceleration=free_acceleration,
        input_map=input_map,
        free_force=free_force,
        force_map=force_map,
        jacobian=equations.jacobian,
        positions=contacts.points(q),
    )


def impact(contacts: Contacts, q: ca.SX, v: ca.SX) -> tuple[ca.SX, ca.SX]:
    """Return the velocities after a plastic impact that stops the feet, (n_q,), and the impulse, (n_f,), N s.

    D (v+ - v) = J^T iota and J v+ = 0 (paper, eq. 4, where the transpose of J is missing).
    """
    robot = contacts.robot
    D = SymmetricFactor.of(dynamics.mass_matrix(robot, q), _elimination_order(robot))
    J = contacts.jacobian(q)
    Y = D.solve(J.T)
    impulse = -SymmetricFactor.of(J @ Y).solve(J @ v)
    return v + Y @ impulse, impulse


def _elimination_order(robot: Robot) -> list[int]:
    """Order that factors the mass matrix without fill: joints from the feet upwards, the base last."""
    return list(range(robot.size - 1, -1, -1))
