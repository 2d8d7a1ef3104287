"""Input-output linearisation of one stance: torques that make y'' + K_d y' + K_p y = 0 (paper, eq. 7 and 8)."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation import AllocationLaw, Redundancy, internal_forces
from amble.hybrid import ConstrainedDynamics, constrained_dynamics
from amble.maths.bezier import bezier
from amble.maths.linear_algebra import solve_square
from amble.robot import Robot

POSITION_SIZE = 3

LATEST_PHASE = 1.05
"""Phase up to which the reference polynomials are followed: beyond 1, so that the closed loop is analytic around an
orbit whose touchdown comes at phase 1 in either direction; not far beyond, where a polynomial of high order grows."""


@dataclass(frozen=True)
class Feedforward:
    """Symbols that set the output dynamics of one domain, in the order in which they are packed.

    Attributes:
        duration: T, s.
        gains: (K_p, K_d).
        references: Bezier coefficients of y_d for y_a = (roll, pitch, yaw, joints), (n_a, order + 1).
        weights: H of y = H (y_a - y_d), (n_y, n_a).
    """

    duration: ca.SX
    gains: ca.SX
    references: ca.SX
    weights: ca.SX

    @classmethod
    def symbols(cls, outputs: int, coordinates: int, order: int) -> Feedforward:
        """Create the symbols for n_y outputs of n_a coordinates."""
        return cls(
            ca.SX.sym("T"),
            ca.SX.sym("gains", 2),
            ca.SX.sym("references", coordinates, order + 1),
            ca.SX.sym("weights", outputs, coordinates),
        )

    def packed(self) -> ca.SX:
        """One column of parameters; matrices column by column."""
        return ca.vertcat(self.duration, self.gains, ca.vec(self.references), ca.vec(self.weights))


@dataclass(frozen=True)
class Linearised:
    """The closed loop of one stance.

    Attributes:
        acceleration: q'', (n_q,).
        torques: u, (n_joints,), N m.
        forces: contact forces of the stance feet, world frame, (3 n_c,), N.
        pivots: pivots met in solving the decoupling equations, (n_joints,); the smallest tells when rank is lost.
        redundancy: the free directions at this state, with the minimum-norm torques.
        response: K, the accelerations that unit output accelerations cause, H S K = I, (n_q, n_y).
        motion: the constrained dynamics.
    """

    acceleration: ca.SX
    torques: ca.SX
    forces: ca.SX
    pivots: ca.SX
    redundancy: Redundancy
    response: ca.SX
    motion: ConstrainedDynamics


def desired(time: ca.SX, feedforward: Feedforward) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return y_d and its first two time derivatives, (n_a,) each.

    After ``LATEST_PHASE`` the curve goes on with its last acceleration, so that a late touchdown meets a
    twice differentiable reference instead of a polynomial far outside its range.
    """
    T = feedforward.duration
    phase = time / T
    inside = ca.fmin(phase, LATEST_PHASE)
    late = (phase - inside) * T
    value, slope, curvature = bezier(feedforward.references, inside)
    rate, second = slope / T, curvature / T**2
    return value + rate * late + 0.5 * second * late**2, rate + second * late, second


def required_output_acceleration(q: ca.SX, v: ca.SX, time: ca.SX, feedforward: Feedforward) -> ca.SX:
    """Return w with y_a'' = w for every coordinate of y_a when its own error obeys the output dynamics, (n_a,)."""
    kp, kd = feedforward.gains[0], feedforward.gains[1]
    value, rate, second = desired(time, feedforward)
    return second - kd * (v[POSITION_SIZE:] - rate) - kp * (q[POSITION_SIZE:] - value)


def linearise(
    robot: Robot,
    feet: tuple[str, ...],
    law: AllocationLaw,
    q: ca.SX,
    v: ca.SX,
    time: ca.SX,
    feedforward: Feedforward,
) -> Linearised:
    """Write the closed loop of a stance as expressions.

    With A = H S G (S picks y_a) and N spanning the torques that cause no acceleration, [A; N^T] u = [r; 0] has the
    minimum-norm solution A^+ r of the paper's eq. 8; the law then moves along N.
    """
    # shorthand
    motion = constrained_dynamics(robot, feet, q, v)
    f0, G = motion.free_acceleration, motion.input_map
    H = feedforward.weights

    wanted = required_output_acceleration(q, v, time, feedforward)
    A = H @ G[POSITION_SIZE:, :]
    r = H @ (wanted - f0[POSITION_SIZE:])
    free = _free_directions(robot, feet, v, motion)
    outputs = A.shape[0]
    right = ca.horzcat(r, ca.SX.eye(outputs))
    solution = solve_square(ca.vertcat(A, free.null.T), ca.vertcat(right, ca.SX(free.size, 1 + outputs)))
    smallest = solution.value[:, 0]
    redundancy = Redundancy(
        robot,
        feet,
        smallest,
        free.null,
        motion.free_force + motion.force_map @ smallest,
        free.squeeze,
        free.speeds,
    )
    s = law.choose(redundancy)
    u = redundancy.torques + redundancy.null @ s
    forces = motion.free_force + motion.force_map @ u
    return Linearised(f0 + G @ u, u, forces, solution.pivots, redundancy, G @ solution.value[:, 1:], motion)


def _free_directions(robot: Robot, feet: tuple[str, ...], v: ca.SX, motion: ConstrainedDynamics) -> Redundancy:
    """The torques -J_legs^T W that cancel internal forces W, scaled to unit size of W's columns."""
    joints = len(robot.joints)
    squeeze = internal_forces(motion.positions)
    legs = motion.jacobian[:, robot.size - joints :]
    # D a + h = B u + J^T lambda: adding W s to lambda leaves a unchanged when u changes by -(leg rows of J^T) W s.
    null = -legs.T @ squeeze if squeeze.shape[1] else ca.SX(joints, 0)
    nothing = ca.SX(joints, 1)
    return Redundancy(robot, feet, nothing, null, ca.SX(squeeze.shape[0], 1), squeeze, v[robot.size - joints :])
