"""Input-output linearisation of one stance: torques that make y'' + K_d y' + K_p y = 0 (paper, eq. 7 and 8)."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation import AllocationLaw, Redundancy
from amble.control.motion_equations import BASE_SIZE, MotionEquations
from amble.control.virtual_constraints import VirtualConstraints, commanded_acceleration
from amble.hybrid import Contacts
from amble.robot import dynamics


@dataclass(frozen=True)
class Linearised:
    """The closed loop of one stance.

    Attributes:
        acceleration: q'', (n_q,).
        torques: u, (n_joints,), N m.
        forces: contact forces of the stance feet, world frame, (n_f,), N.
        redundancy: the free directions at this state, with the minimum-norm torques.
        equations: the factored equations of motion; their pivots tell when the outputs cannot be decoupled.
    """

    acceleration: ca.SX
    torques: ca.SX
    forces: ca.SX
    redundancy: Redundancy
    equations: MotionEquations

    @property
    def pivot(self) -> ca.SX:
        """Smallest pivot of the equations: its distance from lost rank."""
        return ca.mmin(self.equations.pivots)


def linearise(
    contacts: Contacts,
    law: AllocationLaw,
    q: ca.SX,
    v: ca.SX,
    time: ca.SX,
    constraints: VirtualConstraints,
) -> Linearised:
    """Write the closed loop of a stance as expressions.

    Of all torques that realise the motion, N^T u = 0 with N spanning those that cause no acceleration picks the
    minimum-norm solution A^+ r of the paper's eq. 8 (docs/theory/allocation.md, eq. 6); the law then moves along N.

    Raises:
        InputError: where the stance does not allow exactly as many outputs.
    """
    # shorthand
    h = dynamics.bias(contacts.robot, q, v)
    J = (equations := MotionEquations.of(contacts, q, constraints.null_space)).jacobian

    commanded = commanded_acceleration(q, v, time, constraints)
    # with u = (D a + h - J^T lambda)_joints, N^T u = 0 is a row for a and lambda, next to the base's six
    a, smallest = equations.solve(commanded, -contacts.bias(q, v), -equations.rows @ h)
    u = (equations.mass @ a + h - J.T @ smallest)[BASE_SIZE:]
    redundancy = Redundancy.at(contacts, (q, v), (u, smallest), (equations.torque_basis, equations.force_basis))
    chosen = redundancy.moved(law.allocate(redundancy))
    return Linearised(a, chosen.torques, chosen.forces, redundancy, equations)
