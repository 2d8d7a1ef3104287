"""The closed loop of one stance as numbers: the output dynamics, and its motion integrated to high accuracy."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import count

import numpy as np

from amble.errors import WorkError
from amble.hybrid import Contacts
from amble.numerics.bezier import evaluate
from amble.types import Matrix, Vector
from amble.verification.stance_model import Motion, Terms, smallest_torques, terms

INTEGRATION_TOLERANCE = 1e-11
"""Relative and absolute tolerance of the reference integration, far below the tolerance of a check."""

MOST_EVALUATIONS = 5000
"""Evaluations of one integration; walks of ASTRo take 280 to 420. From numbers that are no motion it may not end."""


@dataclass(frozen=True)
class OutputDynamics:
    """y'' + K_d y' + K_p y = 0 with y = H (y_a - y_d), y_a = (roll, pitch, yaw, joints).

    Attributes:
        weights: H, (n_y, n_a).
        references: Bezier coefficients of y_d, (n_a, order + 1).
        duration: s.
        gains: (K_p, K_d).
    """

    weights: Matrix
    references: Matrix
    duration: float
    gains: tuple[float, float]

    def desired(self, times: Vector) -> tuple[Matrix, Matrix, Matrix]:
        """Return y_d and its first two time derivatives, (points, n_a) each."""
        value, first, second = evaluate(self.references, np.asarray(times) / self.duration)
        return value, first / self.duration, second / self.duration**2

    def errors(self, times: Vector, q: Matrix, v: Matrix) -> tuple[Matrix, Matrix]:
        """Return y and y', (points, n_y) each."""
        value, rate, _ = self.desired(times)
        return (q[:, 3:] - value) @ self.weights.T, (v[:, 3:] - rate) @ self.weights.T

    def commanded(self, times: Vector, q: Matrix, v: Matrix) -> Matrix:
        """Return w: the accelerations at which every coordinate of y_a obeys the output dynamics, (points, n_a)."""
        kp, kd = self.gains
        value, rate, second = self.desired(times)
        return second - kd * (v[:, 3:] - rate) - kp * (q[:, 3:] - value)

    def solve(self, at: Terms, times: Vector, q: Matrix, v: Matrix) -> Motion:
        """Return the closed-loop motion with the smallest torques at many states."""
        return smallest_torques(at, self.weights, self.commanded(times, q, v))


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
