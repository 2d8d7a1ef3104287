"""The closed loop of one stance as numbers: the output dynamics, and its motion integrated to high accuracy."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

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

EVALUATIONS, LEAST_EVALUATIONS = 800, 2000
"""Evaluations of a check's integrations, for every domain, and in all at least; walks of ASTRo take up to 420 a domain.
From numbers that are no motion an integration may not end."""


@dataclass
class Effort:
    """What integrations along all domains of a gait may still take together.

    Attributes:
        left: evaluations of the closed loop.
    """

    left: int

    @classmethod
    def of(cls, domains: int) -> Effort:
        """Return what so many domains may take."""
        return cls(max(LEAST_EVALUATIONS, EVALUATIONS * domains))


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
    """y'' + K_d y' + K_p y = 0 with y = H (y_a - y_d), y_a = (roll, pitch, yaw, joints), in the plane (pitch, joints).

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

    @property
    def _base(self) -> int:
        """Coordinates of the base's position, which are not in y_a."""
        return len(self.domain.robot.base.axes)

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
        return (q[:, self._base :] - desired.value) @ self.weights.T, (
            v[:, self._base :] - desired.rate
        ) @ self.weights.T

    def rows(self, times: Vector, q: Matrix, v: Matrix) -> tuple[Stack, Matrix]:
        """Return Y and c of the output dynamics Y a = c, (points, n_y, n_q) and (points, n_y)."""
        kp, kd = self.gains
        desired = self.desired(times, q, v)
        seen = -desired.response
        seen[:, :, self._base :] += np.eye(len(self.references))
        commanded = desired.known - kd * (v[:, self._base :] - desired.rate) - kp * (q[:, self._base :] - desired.value)
        return np.einsum("ya,pan->pyn", self.weights, seen), commanded @ self.weights.T

    def residuals(self, times: Vector, q: Matrix, v: Matrix, a: Matrix) -> Matrix:
        """Return y'' + K_d y' + K_p y at given accelerations, (points, n_y)."""
        rows, commanded = self.rows(times, q, v)
        return np.einsum("pyn,pn->py", rows, a) - commanded

    def solve(self, at: Terms, times: Vector, q: Matrix, v: Matrix) -> Motion:
        """Return the closed-loop motion with the smallest torques at many states."""
        return smallest_torques(at, *self.rows(times, q, v))


@dataclass(frozen=True, kw_only=True)
class Record:
    """A motion that an integration follows as long as it is near.

    Attributes:
        states: q and v at the times asked for, (points, 2 n_q).
        near: largest distance from it of every coordinate and rate, (2 n_q,).
    """

    states: Matrix
    near: Vector


@np.errstate(over="ignore", invalid="ignore")  # a trial step may leave the numbers there are: it is refused
def integrate(
    contacts: Contacts,
    loop: OutputDynamics,
    q: Vector,
    v: Vector,
    times: Vector,
    effort: Effort | None = None,
    record: Record | None = None,
) -> tuple[Matrix, Matrix]:
    """Integrate the closed loop from (q, v) at the first time; return q and v at all times, (points, n_q) each.

    The allocation law does not matter: it does not change the acceleration (docs/theory/allocation.md, eq. 6).

    Args:
        contacts: of the stance.
        loop: the output dynamics.
        q: coordinates at the first time, (n_q,).
        v: rates, (n_q,).
        times: where states are asked for, rising, s, (points,).
        effort: what may be spent; what one domain may take where not given.
        record: end at the first time at which the motion is not near this one; it is the last that is returned.

    Raises:
        WorkError: the integration fails, or the effort is spent.
    """
    from scipy.integrate import DOP853

    size, effort = contacts.robot.size, effort or Effort.of(1)
    what = f"the motion of stance {', '.join(contacts.feet)} cannot be integrated"

    def rate(t: float, x: Vector) -> Vector:
        if effort.left <= 0:
            raise WorkError(f"{what}: the evaluations that a check takes at most were spent at {t:g} s")
        effort.left -= 1
        if not np.all(np.isfinite(x)):
            return np.full_like(x, np.nan)  # no decomposition takes it; the solver tries a shorter step
        q, v = x[None, :size], x[None, size:]
        motion = loop.solve(terms(contacts, q, v), np.array([t]), q, v)
        return np.concatenate([v[0], motion.accelerations[0]])

    accuracy = {"rtol": INTEGRATION_TOLERANCE, "atol": INTEGRATION_TOLERANCE}
    solver = DOP853(rate, times[0], np.concatenate([q, v]), times[-1], **accuracy)
    states = [solver.y]
    while len(states) < len(times):
        if solver.status == "running":
            message = solver.step()
        if solver.status == "failed":
            raise WorkError(f"{what}: {message}")
        at = times[len(states) : int(np.searchsorted(times, solver.t, side="right"))]
        states += list(solver.dense_output()(at).T) if len(at) else []
        gone = record is not None and np.abs(states - record.states[: len(states)]) > record.near
        if np.any(gone):
            del states[int(np.argmax(np.any(gone, axis=1))) + 1 :]
            break
    found = np.array(states)
    return found[:, :size], found[:, size:]
