"""Derivatives of the closed loop without differentiating its solves: the linear equations are perturbed instead.

Automatic differentiation of the whole closed loop of ASTRo takes 449,000 operations, this a fifth of them.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.linearisation import (
    POSITION_SIZE,
    Feedforward,
    Linearised,
    required_output_acceleration,
)
from amble.hybrid import selection, stance_bias, stance_jacobian
from amble.robot import Robot, dynamics


@dataclass(frozen=True)
class Sensitivity:
    """First-order behaviour of the closed loop around a state.

    Attributes:
        acceleration: d q'' / d (q, v), (n_q, 2 n_q).
        error: E = d (y_a'' - w) / d (q, v), what every coordinate of y_a misses of its own error dynamics,
            (n_a, 2 n_q). H E = 0; a change dH of the weights changes ``acceleration`` by -K dH E, with K the
            response of the outputs, where the error itself is zero.
    """

    acceleration: ca.SX
    error: ca.SX


def sensitivity(
    robot: Robot,
    feet: tuple[str, ...],
    linearised: Linearised,
    q: ca.SX,
    v: ca.SX,
    time: ca.SX,
    feedforward: Feedforward,
) -> Sensitivity:
    """Perturb D a + h = B u + J^T lambda, J a + Jdot v = 0 and H (S a - w) = 0 in q and v.

    The law does not enter: torques that differ by a free direction cause the same acceleration.
    """
    # shorthand
    motion, H, K = linearised.motion, feedforward.weights, linearised.response
    state = ca.vertcat(q, v)

    a, u = ca.SX.sym("a", robot.size), ca.SX.sym("u", len(robot.joints))
    lam = ca.SX.sym("lambda", 3 * len(feet))
    J = stance_jacobian(robot, feet, q)
    force = dynamics.inverse_dynamics(robot, q, v, a) - selection(robot) @ u - J.T @ lam
    contact = J @ a + stance_bias(robot, feet, q, v)
    at = (linearised.acceleration, linearised.torques, linearised.forces)
    slopes = ca.Function("slopes", [q, v, a, u, lam], [ca.jacobian(force, state), ca.jacobian(contact, state)])(
        q, v, *at
    )
    uncontrolled = motion.respond(-slopes[0], -slopes[1])
    wanted = ca.jacobian(required_output_acceleration(q, v, time, feedforward), state)
    missing = wanted - uncontrolled[POSITION_SIZE:, :]
    acceleration = uncontrolled + K @ (H @ missing)
    return Sensitivity(acceleration, acceleration[POSITION_SIZE:, :] - wanted)
