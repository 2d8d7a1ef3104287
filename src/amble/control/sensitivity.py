"""Derivatives of the closed loop without differentiating its solves: the linear equations are perturbed instead.

Automatic differentiation of the whole closed loop of ASTRo takes 449,000 operations, this a fifth of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.linearisation import Linearised
from amble.control.virtual_constraints import VirtualConstraints, commanded_acceleration, reference_slope
from amble.hybrid import Contacts
from amble.robot import dynamics


@dataclass(frozen=True)
class Sensitivity:
    """First-order behaviour of the closed loop around a state.

    Attributes:
        acceleration: d q'' / d (q, v), (n_q, 2 n_q).
        response: R, the accelerations that a change of w causes, (n_q, n_a); H S R = H.
        error: E = d (y_a'' - w) / d (q, v), what every coordinate of y_a misses of its own error dynamics,
            (n_a, 2 n_q). H E = 0; a change dH of the weights changes ``acceleration`` by -K dH E where the error
            itself is zero, with the response K = R H^+ of the outputs.
    """

    acceleration: ca.SX
    response: ca.SX
    error: ca.SX


def sensitivity(
    contacts: Contacts,
    linearised: Linearised,
    q: ca.SX,
    v: ca.SX,
    constraints: VirtualConstraints,
) -> Sensitivity:
    """Perturb the equations of ``MotionEquations`` in q and v.

    Neither the law nor the joints' rows enter: torques that differ by a free direction cause the same acceleration,
    and the base's rows hold no torque.
    """
    # shorthand
    robot, equations = contacts.robot, linearised.equations
    J, state = equations.jacobian, ca.vertcat(q, v)

    a, lam = ca.SX.sym("a", robot.size), ca.SX.sym("lambda", contacts.size)
    force = (dynamics.inverse_dynamics(robot, q, v, a) - J.T @ lam)[: robot.base.size]
    contact = J @ a + contacts.bias(q, v)
    at = linearised.acceleration, linearised.forces
    slopes = ca.Function("slopes", [q, v, a, lam], [ca.jacobian(force, state), ca.jacobian(contact, state)])(q, v, *at)
    commanded, second = _commanded(linearised, q, v, constraints)

    coordinates, free = commanded.shape[0], equations.torque_basis.shape[1]
    acceleration, _ = equations.solve(commanded, -slopes[1], ca.vertcat(-slopes[0], ca.SX(free, 2 * robot.size)))
    response, _ = equations.solve(
        ca.SX.eye(coordinates), ca.SX(contact.shape[0], coordinates), ca.SX(robot.base.size + free, coordinates)
    )
    closure = linearised.closure
    if closure is None:
        return Sensitivity(acceleration, response, acceleration[equations.position :, :] - commanded)
    change = closure.second(acceleration, second)
    acceleration += closure.acceleration @ change
    response += closure.acceleration @ closure.second(response)
    return Sensitivity(
        acceleration, response, acceleration[equations.position :, :] - commanded - closure.slope @ change
    )


def _commanded(linearised: Linearised, q: ca.SX, v: ca.SX, constraints: VirtualConstraints) -> tuple[ca.SX, ca.SX]:
    """Slopes of w at fixed s'' and of s'' at fixed accelerations: (n_a, 2 n_q) and (1, 2 n_q)."""
    # shorthand
    phase, a, state = linearised.phase, linearised.acceleration, ca.vertcat(q, v)

    slope = ca.jacobian(commanded_acceleration(q, v, phase, constraints, ca.SX(1, 1)), state)
    direction = ca.jacobian(reference_slope(phase, constraints), state) if linearised.closure else ca.SX(*slope.shape)
    second = a.T @ ca.jacobian(phase.gradient.T, state) + ca.jacobian(phase.bias, state)
    return slope + direction * phase.second(a), second
