"""The closed loop of a stance as linear equations M z = b, of which nothing is eliminated.

The unknowns are accelerations, torques and contact forces together. Formulas that eliminate some of them are quick, but
enclosures do not survive them: written out they widen a ball 10^6-fold (docs/theory/proof.md, section 6). The entries
of M and b are products of sines, cosines and polynomials; solved as they stand, with an approximate inverse of M, they
widen it by little more than the slope of the solution.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation import AllocationLaw, Redundancy
from amble.control.phase import PhaseRates
from amble.control.virtual_constraints import (
    VirtualConstraints,
    commanded_acceleration,
    reference_slope,
)
from amble.errors import InputError
from amble.hybrid import Contacts, selection
from amble.robot import dynamics


@dataclass(frozen=True, kw_only=True)
class LoopEquations:
    """M z = b with z = (q'', u / g, lambda / g, rest).

    Attributes:
        matrix: M, (n, n).
        right: b, (n,).
        load: g, the robot's weight, by which torques and forces are scaled, N (torques by it times 1 m).
        accelerations: n_q.
        torques: n_joints.
        forces: n_f.
    """

    matrix: ca.SX
    right: ca.SX
    load: float
    accelerations: int
    torques: int
    forces: int

    def parts(self, solution: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
        """Return accelerations, torques, N m, and contact forces in the world frame, N, of a solution z."""
        a, u, f = self.accelerations, self.torques, self.forces
        return solution[:a], self.load * solution[a : a + u], self.load * solution[a + u : a + u + f]


def linearised_equations(
    contacts: Contacts,
    law: AllocationLaw,
    state: tuple[ca.SX, ca.SX],
    phase: PhaseRates,
    constraints: VirtualConstraints,
) -> LoopEquations:
    """Write the loop of ``linearisation.linearise`` for a law whose conditions are linear in the torques.

    D a - B u - J^T lambda = -h, J a = -Jdot v, S a - Z c - B' s'' = w, K u = 0 and, where the phase depends on the
    configuration, s'' - J_s a = bias: c are the outputs' free accelerations along the kernel Z of H, K the law's rows.

    Args:
        contacts: the stance feet on the ground.
        law: the allocation law.
        state: coordinates and their rates, (n_q,) each.
        phase: the phase variable there.
        constraints: gains, references and output null space.

    Raises:
        InputError: the law's torques are no solution of linear equations, or the number of outputs does not fit.
    """
    # shorthand
    robot, (q, v) = contacts.robot, state
    n, m, f, load = robot.size, len(robot.joints), contacts.size, robot.mass * robot.gravity
    y = n - len(robot.base.axes)
    Z, J, K = constraints.null_space, contacts.jacobian(q), law_rows(contacts, law, q, v)
    S = ca.horzcat(ca.SX(y, n - y), ca.SX.eye(y))
    extra = Z.shape[1] + int(phase.by_state)
    if m - K.shape[0] != y - Z.shape[1]:
        raise InputError(f"a stance on {len(contacts.feet)} feet takes exactly {m - K.shape[0]} outputs")

    second = phase.bias if not phase.by_state else ca.SX(1, 1)
    rows = [
        ca.horzcat(dynamics.mass_matrix(robot, q) / load, -selection(robot), -J.T, ca.SX(n, extra)),
        ca.horzcat(J, ca.SX(f, m + f + extra)),
        ca.horzcat(S, ca.SX(S.shape[0], m + f), -Z),
        ca.horzcat(ca.SX(K.shape[0], n), K, ca.SX(K.shape[0], f + extra)),
    ]
    right = [
        -dynamics.bias(robot, q, v) / load,
        -contacts.bias(q, v),
        commanded_acceleration(q, v, phase, constraints, second),
        ca.SX(K.shape[0], 1),
    ]
    if phase.by_state:
        rows[2] = ca.horzcat(rows[2], -reference_slope(phase, constraints))
        rows.append(ca.horzcat(-phase.gradient, ca.SX(1, m + f + extra - 1), 1))
        right.append(phase.bias)
    return LoopEquations(
        matrix=ca.vertcat(*rows), right=ca.densify(ca.vertcat(*right)), load=load, accelerations=n, torques=m, forces=f
    )


def driven_equations(contacts: Contacts, torques: ca.SX, state: tuple[ca.SX, ca.SX]) -> LoopEquations:
    """Write the loop of a law that gives the torques: D a - B u - J^T lambda = -h, J a = -Jdot v, u = torques.

    Args:
        contacts: the stance feet on the ground.
        torques: (n_joints,), N m.
        state: coordinates and their rates, (n_q,) each.
    """
    robot, (q, v) = contacts.robot, state
    n, m, f, load = robot.size, len(robot.joints), contacts.size, robot.mass * robot.gravity
    J = contacts.jacobian(q)
    rows = [
        ca.horzcat(dynamics.mass_matrix(robot, q) / load, -selection(robot), -J.T),
        ca.horzcat(J, ca.SX(f, m + f)),
        ca.horzcat(ca.SX(m, n), ca.SX.eye(m), ca.SX(m, f)),
    ]
    right = ca.vertcat(-dynamics.bias(robot, q, v) / load, -contacts.bias(q, v), torques / load)
    return LoopEquations(
        matrix=ca.vertcat(*rows), right=ca.densify(right), load=load, accelerations=n, torques=m, forces=f
    )


def law_rows(contacts: Contacts, law: AllocationLaw, q: ca.SX, v: ca.SX) -> ca.SX:
    """Return K with K u = 0 exactly where the torques obey a law, (k, n_joints).

    Raises:
        InputError: the law's conditions are not linear in the torques.
    """
    u, forces = ca.SX.sym("u", len(contacts.robot.joints)), ca.SX.sym("lambda", contacts.size)
    redundancy = Redundancy.at(contacts, (q, v), (u, forces))
    if not redundancy.size:
        return ca.SX(0, u.shape[0])
    smooth = type(law).optimality_conditions is not AllocationLaw.optimality_conditions
    conditions = law.optimality_conditions(redundancy) if smooth else ca.SX(1, 1)
    rows = ca.jacobian(conditions, u)
    constant = ca.substitute(conditions, u, ca.SX.zeros(u.shape[0]))
    if not smooth or ca.depends_on(rows, ca.vertcat(u, forces)) or not constant.is_zero():
        raise InputError(
            f"the torques of allocation law '{law.name}' do not solve linear equations; those of pinv, weighted and "
            "drop do, and the motion under input-output linearisation is the same"
        )
    return rows
