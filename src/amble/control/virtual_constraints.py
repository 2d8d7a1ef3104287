"""What sets the output dynamics of one domain: reference curves, gains, and the directions that no output sees."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.numerics.bezier import bernstein_derivatives
from amble.types import Matrix, Vector

POSITION_SIZE = 3

LATEST_PHASE = 1.05
"""Phase up to which the reference polynomials are followed: beyond 1, so that the closed loop is analytic around an
orbit whose touchdown comes at phase 1 in either direction; not far beyond, where a polynomial of high order grows."""

DEPENDENT = 1e-10
"""Output weights whose smallest singular value is below this share of the largest are not independent."""


@dataclass(frozen=True)
class VirtualConstraints:
    """Symbols that set the output dynamics of one domain, in the order in which they are packed.

    The weights H of y = H (y_a - y_d) enter by their kernel alone: y'' + K_d y' + K_p y = 0 says that y_a'' - w lies in
    it, with w of ``commanded_acceleration``. So weights of the same kernel are the same controller.

    Attributes:
        duration: T, s.
        gains: (K_p, K_d).
        references: Bezier coefficients of y_d for y_a = (roll, pitch, yaw, joints), (n_a, order + 1).
        null_space: orthonormal basis of the kernel of H, (n_a, n_a - n_y).
    """

    duration: ca.SX
    gains: ca.SX
    references: ca.SX
    null_space: ca.SX

    @classmethod
    def symbols(cls, outputs: int, coordinates: int, order: int) -> VirtualConstraints:
        """Create the symbols for n_y outputs of n_a coordinates."""
        return cls(
            ca.SX.sym("T"),
            ca.SX.sym("gains", 2),
            ca.SX.sym("references", coordinates, order + 1),
            ca.SX.sym("null_space", coordinates, coordinates - outputs),
        )

    def packed(self) -> ca.SX:
        """One column of parameters; matrices column by column."""
        return ca.vertcat(self.duration, self.gains, ca.vec(self.references), ca.vec(self.null_space))


def pack(duration: float, gains: tuple[float, float], references: Matrix, weights: Matrix) -> Vector:
    """Pack numbers as ``VirtualConstraints.packed`` does its symbols.

    Args:
        duration: T, s.
        gains: (K_p, K_d).
        references: Bezier coefficients, (n_a, order + 1).
        weights: H, (n_y, n_a).

    Raises:
        InputError: where the rows of H are dependent.
    """
    parts = [[duration], gains, np.ravel(references, order="F"), output_null_space(weights).ravel(order="F")]
    return np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])


def repacked(parameters: Vector, weights: Matrix) -> Vector:
    """Return packed parameters with other output weights H, (n_y, n_a); errors as in ``pack``."""
    null_space = output_null_space(weights).ravel(order="F")
    return np.concatenate([parameters[: parameters.size - null_space.size], null_space])


def reference_end(parameters: Vector) -> float:
    """Return the clock at which the reference polynomials of packed parameters end, s; there y_d has a breakpoint."""
    return LATEST_PHASE * float(parameters[0])


def output_null_space(weights: Matrix) -> Matrix:
    """Return an orthonormal basis of the kernel of H, (n_a, n_a - n_y).

    Raises:
        InputError: where H is not finite or its rows are dependent.
    """
    matrix = np.asarray(weights, dtype=np.float64)
    if not np.all(np.isfinite(matrix)):
        raise InputError("the output weights are not finite")
    _, values, basis = np.linalg.svd(matrix)
    if values.size and not values[-1] > DEPENDENT * values[0]:
        raise InputError("the rows of the output weights are dependent")
    return basis[matrix.shape[0] :].T


def commanded_acceleration(q: ca.SX, v: ca.SX, time: ca.SX, constraints: VirtualConstraints) -> ca.SX:
    """Return w with y_a'' = w for every coordinate of y_a when its own error obeys the output dynamics, (n_a,).

    w = y_d'' - K_d (y_a' - y_d') - K_p (y_a - y_d); the three curves share one product with their coefficients.
    """
    kp, kd = constraints.gains[0], constraints.gains[1]
    value, rate, second = _basis(time, constraints)
    return constraints.references @ (second + kd * rate + kp * value) - kd * v[POSITION_SIZE:] - kp * q[POSITION_SIZE:]


def _basis(time: ca.SX, constraints: VirtualConstraints) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Bernstein polynomials as functions of time, with their first two derivatives, (order + 1,) each.

    After ``LATEST_PHASE`` they go on with their last second derivative, so that a late touchdown meets a twice
    differentiable reference instead of a polynomial far outside its range.
    """
    T = constraints.duration
    phase = time / T
    inside = ca.fmin(phase, LATEST_PHASE)
    late = phase - inside
    order = constraints.references.shape[1] - 1
    value, slope, curvature = (ca.vertcat(*row) for row in bernstein_derivatives(order, inside))
    return (
        value + slope * late + 0.5 * curvature * late**2,
        (slope + curvature * late) / T,
        curvature / T**2,
    )
