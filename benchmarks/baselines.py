"""How others allocate the torques: a basic solution by pivoting, and a whole-body quadratic program."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import sqrt
from typing import Any

import casadi as ca
import numpy as np
import pinocchio as pin
import proxsuite
import quadprog
from scipy import linalg

from amble.control.outputs import selection_matrix
from amble.control.virtual_constraints import VirtualConstraints, commanded_acceleration
from amble.gait import Gait
from amble.gait.constraints import REFERENCE_ORDER, loop_parameters
from amble.hybrid import Stance, constrained_dynamics
from amble.robot import Robot
from amble.types import Matrix, Vector

REGULARISATION = 1e-8
"""Weight of accelerations and forces in the program, beside 1 for torques: quadprog needs a definite Hessian."""


@dataclass(frozen=True)
class Task:
    """What one stance asks of the torques at (clock, x): y'' = A u + b, and the wanted output accelerations.

    Attributes:
        gait: the gait.
        stance: the stance.
    """

    gait: Gait
    stance: Stance

    @property
    def robot(self) -> Robot:
        """The robot that walks."""
        return self.gait.robot

    @cached_property
    def parameters(self) -> Vector:
        """Packed references, gains and kernel of the weights."""
        return loop_parameters(self.gait, self.stance.name)

    @cached_property
    def weights(self) -> Matrix:
        """H, (n_y, n_a)."""
        if self.gait.feedback is not None:
            return self.gait.feedback.weights[self.stance.name]
        return selection_matrix(self.robot, self.gait.outputs.of(self.stance.name))

    @cached_property
    def wide_system(self) -> ca.Function:
        """(clock, x) -> A, r with A u = r."""
        t, x, q, v, wanted = self._symbols()
        motion = constrained_dynamics(self.gait.pattern.contacts(self.stance), q, v)
        A = ca.DM(self.weights) @ motion.input_map[3:, :]
        r = ca.DM(self.weights) @ (wanted - motion.free_acceleration[3:])
        return ca.Function("wide_system", [t, x], [ca.densify(A), ca.densify(r)])

    @cached_property
    def wanted(self) -> ca.Function:
        """(clock, x) -> wanted accelerations of roll, pitch, yaw and the joints."""
        t, x, _, _, wanted = self._symbols()
        return ca.Function("wanted", [t, x], [wanted])

    def _symbols(self) -> tuple[ca.SX, ca.SX, ca.SX, ca.SX, ca.SX]:
        t, x = ca.SX.sym("t"), ca.SX.sym("x", 2 * self.robot.size)
        q, v = x[: self.robot.size], x[self.robot.size :]
        order, phase = REFERENCE_ORDER, self.gait.outputs.phase
        symbols = VirtualConstraints.symbols(len(self.weights), self.robot.size - 3, order, phase)
        rates = symbols.phase_rates(self.robot, self.stance, t, q, v)
        wanted = commanded_acceleration(q, v, rates, symbols, rates.bias)
        values = ca.substitute(wanted, symbols.packed(), ca.SX(ca.DM(self.parameters)))
        return t, x, q, v, values


def basic_solution(A: Matrix, r: Vector) -> tuple[Vector, int]:
    """Solve a wide system as MATLAB's backslash does: pivoted QR, the variables pivoted last are zero.

    Returns:
        The solution, and the index of the first variable that was set to zero.
    """
    Q, R, order = linalg.qr(A, mode="economic", pivoting=True)
    rank = len(A)
    u = np.zeros(A.shape[1])
    u[order[:rank]] = linalg.solve_triangular(R[:, :rank], Q.T @ r)
    return u, int(order[rank])


class PinocchioModel:
    """The model evaluation of a whole-body controller: Pinocchio in amble's coordinates.

    Args:
        robot: the robot.
        urdf: its file.
    """

    def __init__(self, robot: Robot, urdf: str) -> None:
        base = pin.JointModelComposite()
        for joint in ("PX", "PY", "PZ", "RX", "RY", "RZ"):
            base.addJoint(getattr(pin, f"JointModel{joint}")())
        self.model = pin.buildModelFromUrdf(urdf, base)
        self.model.gravity.linear = np.array([0.0, 0.0, -robot.gravity])
        self.data = self.model.createData()
        order = [self.model.joints[self.model.getJointId(name)].idx_v for name in robot.joint_names]
        self.order = np.array([*range(6), *order])
        self.frames = {foot.name: self.model.getFrameId(foot.frame, pin.FrameType.BODY) for foot in robot.feet}

    def evaluate(self, q: Vector, v: Vector, feet: tuple[str, ...]) -> tuple[Matrix, Vector, Matrix, Vector]:
        """Return D, h, J and Jdot v of the stance feet."""
        theirs, rates = np.empty_like(q), np.empty_like(v)
        theirs[self.order], rates[self.order] = q, v
        model, data = self.model, self.data
        pin.computeAllTerms(model, data, theirs, rates)
        pin.forwardKinematics(model, data, theirs, rates, np.zeros_like(v))
        pin.updateFramePlacements(model, data)
        half = np.triu(data.M)
        D = (half + np.triu(half, 1).T)[np.ix_(self.order, self.order)]
        aligned = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        J = np.vstack([pin.getFrameJacobian(model, data, self.frames[foot], aligned)[:3] for foot in feet])
        bias = np.concatenate(
            [pin.getFrameClassicalAcceleration(model, data, self.frames[foot], aligned).linear for foot in feet]
        )
        return D, data.nle[self.order].copy(), J[:, self.order], bias


@dataclass(frozen=True)
class Program:
    """min z^T P z / 2 with C z = d and E z <= f; z = (accelerations, torques, contact forces)."""

    P: Matrix
    C: Matrix
    d: Vector
    E: Matrix
    f: Vector


class WholeBodyProgram:
    """The same motion and limits as the bounded law, as the quadratic program of a whole-body controller.

    Args:
        task: what the stance asks for.
        urdf: file of the robot.
    """

    def __init__(self, task: Task, urdf: str) -> None:
        robot, feet = task.robot, task.stance.feet
        self.task, self.feet = task, feet
        self.model = PinocchioModel(robot, urdf)
        self.n, self.m, self.c = robot.size, len(robot.joints), 3 * len(feet)
        weights = np.concatenate([np.full(self.n, REGULARISATION), np.ones(self.m), np.full(self.c, REGULARISATION)])
        self.P = np.diag(weights)
        slope = task.gait.pattern.ground.friction / sqrt(2.0)
        cone = np.array([[1.0, 0.0, -slope], [-1.0, 0.0, -slope], [0.0, 1.0, -slope], [0.0, -1.0, -slope], [0, 0, -1]])
        u = np.hstack([np.zeros((self.m, self.n)), np.eye(self.m), np.zeros((self.m, self.c))])
        forces = np.hstack([np.zeros((5 * len(feet), self.n + self.m)), np.kron(np.eye(len(feet)), cone)])
        self.E = np.vstack([u, -u, forces])
        effort = np.array([joint.effort for joint in robot.joints])
        least = np.tile([0.0, 0.0, 0.0, 0.0, -task.gait.limits.normal_force], len(feet))
        self.f = np.concatenate([effort, effort, least])
        self._proxqp: Any = None

    def program(self, clock: float, x: Vector) -> Program:
        """Evaluate the model and fill in the program."""
        n, m, c = self.n, self.m, self.c
        D, h, J, bias = self.model.evaluate(x[:n], x[n:], self.feet)
        H = self.task.weights
        wanted = H @ np.asarray(self.task.wanted(clock, x).full()).ravel()
        C = np.zeros((n + c + len(H), n + m + c))
        C[:n, :n], C[n - m : n, n : n + m], C[:n, n + m :] = D, -np.eye(m), -J.T
        C[n : n + c, :n] = J
        C[n + c :, 3:n] = H
        return Program(self.P, C, np.concatenate([-h, -bias, wanted]), self.E, self.f)

    def with_quadprog(self, program: Program) -> Vector:
        """Solve by the dual active-set method; returns the torques."""
        C = np.vstack([program.C, -program.E]).T
        b = np.concatenate([program.d, -program.f])
        z = quadprog.solve_qp(program.P, np.zeros(len(program.P)), C, b, len(program.d))[0]
        return np.asarray(z[self.n : self.n + self.m])

    def with_proxqp(self, program: Program) -> Vector:
        """Solve by the proximal augmented Lagrangian, warm started; returns the torques."""
        free = np.full(len(program.f), -1e20)
        nothing = np.zeros(len(program.P))
        if self._proxqp is None:
            self._proxqp = proxsuite.proxqp.dense.QP(len(program.P), len(program.d), len(program.f))
            self._proxqp.settings.eps_abs = 1e-6
            self._proxqp.settings.compute_timings = True
            self._proxqp.init(program.P, nothing, program.C, program.d, program.E, free, program.f)
        else:
            self._proxqp.update(program.P, nothing, program.C, program.d, program.E, free, program.f)
        self._proxqp.solve()
        return np.array(self._proxqp.results.x[self.n : self.n + self.m])  # a copy: the solver reuses its memory

    def microseconds(self, program: Program) -> float:
        """Solve as ``with_proxqp`` and return the time by the solver's own clock, without Python."""
        self.with_proxqp(program)
        info = self._proxqp.results.info
        return float(info.setup_time + info.solve_time)
