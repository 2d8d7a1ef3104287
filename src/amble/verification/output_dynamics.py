"""The closed loop of one stance as numbers: the output dynamics, and its motion integrated to high accuracy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from itertools import count

import casadi as ca
import numpy as np

from amble.control.phase import DomainPhase
from amble.errors import WorkError
from amble.hybrid import Contacts
from amble.numerics.bezier import evaluate
from amble.types import Matrix, Vector
from amble.verification.stance_model import Motion, Stack, Terms, smallest_torques, terms

INTEGRATION_TOLERANCE = 1e-11
"""Relative and absolute tolerance of the reference integration, far below the tolerance of a check."""

MOST_EVALUATIONS = 2000
"""Evaluations of one integration; walks of ASTRo take 280 to 420. From numbers that are no motion it may not end."""


@dataclass(frozen=True, kw_only=True)
class Desired:
    """What the outputs are held to at many states.

    Attributes:
        value: y_d, (points, n_a).
        rate: y_d', (points, n_a).
        known: y_d'' less what the accelerations contribute, (points, n_a).
        response: d y_d'' / d a, (points, n_a, n_q); zero where the phase is time.
        pace: rate of the phase, 1/s, (points,).
    """

    value: Matrix
    rate: Matrix
    known: Matrix
    response: Stack
    pace: Vector


@dataclass(frozen=True, kw_only=True)
class OutputDynamics:
    """y'' + K_d y' + K_p y = 0 with y = H (y_a - y_d), y_a = (roll, pitch, yaw, joints).

    Attributes:
        weights: H, (n_y, n_a).
        references: Bezier coefficients of y_d over the phase, (n_a, order + 1).
        duration: s.
        gains: (K_p, K_d).
        domain: the phase in this domain.
        phase_numbers: what the phase needs beside the duration, (k,).
    """

    weights: Matrix
    references: Matrix
    duration: float
    gains: tuple[float, float]
    domain: DomainPhase
    phase_numbers: Vector

    def desired(self, times: Vector, q: Matrix, v: Matrix) -> Desired:
        """Return the desired motion at many states, by the chain rule along z = (t / T, q)."""
        share = np.asarray(times) / self.duration
        z = np.column_stack([np.full(len(share), 1.0 / self.duration), v])
        phase, gradient, hessian = self._phase(share, q)
        pace = np.einsum("pz,pz->p", gradient, z)
        bias = np.einsum("pz,pzw,pw->p", z, hessian, z)
        value, slope, curvature = evaluate(self.references, phase)
        return Desired(
            value=value,
            rate=slope * pace[:, None],
            known=curvature * pace[:, None] ** 2 + slope * bias[:, None],
            response=slope[:, :, None] * gradient[:, None, 1:],
            pace=pace,
        )

    def _phase(self, share: Vector, q: Matrix) -> tuple[Vector, Matrix, Stack]:
        """Phase, its gradient and its Hessian in z, (points,), (points, n_z), (points, n_z, n_z)."""
        points, size = q.shape
        found = self._function.map(points)(share[None], q.T)
        value, gradient, hessian = (np.asarray(part) for part in found)
        return value[0], gradient.T, hessian.reshape(size + 1, points, size + 1).transpose(1, 0, 2)

    @cached_property
    def _function(self) -> ca.Function:
        share, q = ca.SX.sym("share"), ca.SX.sym("q", self.domain.robot.size)
        numbers = ca.SX(ca.DM(self.phase_numbers))
        value = ca.SX(self.domain.phase.value(self.domain.robot, self.domain.stance, share, q, numbers))
        hessian, gradient = ca.hessian(value, ca.vertcat(share, q))
        return ca.Function("phase", [share, q], [ca.densify(part) for part in (value, gradient, hessian)])

    def errors(self, times: Vector, q: Matrix, v: Matrix) -> tuple[Matrix, Matrix]:
        """Return y and y', (points, n_y) each."""
        desired = self.desired(times, q, v)
        return (q[:, 3:] - desired.value) @ self.weights.T, (v[:, 3:] - desired.rate) @ self.weights.T

    def rows(self, times: Vector, q: Matrix, v: Matrix) -> tuple[Stack, Matrix]:
        """Return Y and c of the output dynamics Y a = c, (points, n_y, n_q) and (points, n_y)."""
        kp, kd = self.gains
        desired = self.desired(times, q, v)
        seen = -desired.response
        seen[:, :, 3:] += np.eye(len(self.references))
        commanded = desired.known - kd * (v[:, 3:] - desired.rate) - kp * (q[:, 3:] - desired.value)
        return np.einsum("ya,pan->pyn", self.weights, seen), commanded @ self.weights.T

    def residuals(self, times: Vector, q: Matrix, v: Matrix, a: Matrix) -> Matrix:
        """Return y'' + K_d y' + K_p y at given accelerations, (points, n_y)."""
        rows, commanded = self.rows(times, q, v)
        return np.einsum("pyn,pn->py", rows, a) - commanded

    def solve(self, at: Terms, times: Vector, q: Matrix, v: Matrix) -> Motion:
        """Return the closed-loop motion with the smallest torques at many states."""
        return smallest_torques(at, *self.rows(times, q, v))


def integrate(contacts: Contacts, loop: OutputDynamics, q: Vector, v: Vector, times: Vector) -> tuple[Matrix, Matrix]:
    """Integrate the closed loop from (q, v) at the first time; return q and v at all times, (points, n_q) each.

    The allocation law does not matter: it does not change the acceleration (docs/theory/allocation.md, eq. 6).

    Raises:
        WorkError: the integration fails, or takes more than ``MOST_EVALUATIONS``.
    """
    from scipy.integrate import solve_ivp

    size, evaluations = contacts.robot.size, count()
    what = f"the motion of stance {', '.join(contacts.feet)} cannot be integrated"

    def rate(t: float, x: Vector) -> Vector:
        if next(evaluations) == MOST_EVALUATIONS:
            raise WorkError(f"{what}: it took more than {MOST_EVALUATIONS} evaluations to come to {t:g} s")
        q, v = x[None, :size], x[None, size:]
        motion = loop.solve(terms(contacts, q, v), np.array([t]), q, v)
        return np.concatenate([v[0], motion.accelerations[0]])

    accuracy = {"rtol": INTEGRATION_TOLERANCE, "atol": INTEGRATION_TOLERANCE}
    start = np.concatenate([q, v])
    done = solve_ivp(rate, (times[0], times[-1]), start, method="DOP853", t_eval=times, **accuracy)
    if not done.success:
        raise WorkError(f"{what}: {done.message}")
    states = done.y.T
    return states[:, :size], states[:, size:]
