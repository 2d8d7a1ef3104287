"""What sets the output dynamics of one domain: reference curves, gains, and the directions that no output sees."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.control.phase import LATEST_PHASE, DomainPhase, Phase, PhaseRates, TimePhase
from amble.errors import InputError
from amble.hybrid import Stance
from amble.numerics.bezier import bernstein_derivatives
from amble.robot import Robot
from amble.types import Matrix, Vector

DEPENDENT = 1e-10
"""Output weights whose smallest singular value is below this share of the largest are not independent."""


@dataclass(frozen=True, kw_only=True)
class VirtualConstraints:
    """Symbols that set the output dynamics of one domain, in the order in which they are packed.

    The weights H of y = H (y_a - y_d) enter by their kernel alone: y'' + K_d y' + K_p y = 0 says that y_a'' - w lies in
    it, with w of ``commanded_acceleration``. So weights of the same kernel are the same controller.

    Attributes:
        phase: the variable that the references run on.
        duration: T, s.
        phase_numbers: what the phase needs beside T, (k,).
        gains: (K_p, K_d).
        references: Bezier coefficients of y_d for y_a = (roll, pitch, yaw, joints), (n_a, order + 1).
        null_space: orthonormal basis of the kernel of H, (n_a, n_a - n_y).
    """

    phase: Phase
    duration: ca.SX
    phase_numbers: ca.SX
    gains: ca.SX
    references: ca.SX
    null_space: ca.SX

    @classmethod
    def symbols(cls, outputs: int, coordinates: int, order: int, phase: Phase | None = None) -> VirtualConstraints:
        """Create the symbols for n_y outputs of n_a coordinates; the phase is time where none is given."""
        phase = phase or TimePhase()
        return cls(
            phase=phase,
            duration=ca.SX.sym("T"),
            phase_numbers=ca.SX.sym("phase_numbers", len(phase.numbers)),
            gains=ca.SX.sym("gains", 2),
            references=ca.SX.sym("references", coordinates, order + 1),
            null_space=ca.SX.sym("null_space", coordinates, coordinates - outputs),
        )

    def packed(self) -> ca.SX:
        """One column of parameters; matrices column by column."""
        parts = (self.duration, self.phase_numbers, self.gains, ca.vec(self.references), ca.vec(self.null_space))
        return ca.vertcat(*parts)

    def phase_rates(self, robot: Robot, stance: Stance, time: ca.SX, q: ca.SX, v: ca.SX) -> PhaseRates:
        """Return the phase of a domain at a clock and a state."""
        domain = DomainPhase(phase=self.phase, robot=robot, stance=stance)
        return domain.rates(time / self.duration, self.duration, q, v, self.phase_numbers)


def pack(
    duration: float,
    gains: tuple[float, float],
    references: Matrix,
    weights: Matrix,
    phase_numbers: Vector | tuple[float, ...] = (),
) -> Vector:
    """Pack numbers as ``VirtualConstraints.packed`` does its symbols.

    Args:
        duration: T, s.
        gains: (K_p, K_d).
        references: Bezier coefficients, (n_a, order + 1).
        weights: H, (n_y, n_a).
        phase_numbers: what the phase needs beside T.

    Raises:
        InputError: where the rows of H are dependent.
    """
    matrices = [np.ravel(references, order="F"), output_null_space(weights).ravel(order="F")]
    parts = [[duration], phase_numbers, gains, *matrices]
    return np.concatenate([np.asarray(part, dtype=np.float64) for part in parts])


def repacked(parameters: Vector, weights: Matrix) -> Vector:
    """Return packed parameters with other output weights H, (n_y, n_a); errors as in ``pack``."""
    null_space = output_null_space(weights).ravel(order="F")
    return np.concatenate([parameters[: parameters.size - null_space.size], null_space])


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


def commanded_acceleration(
    q: ca.SX, v: ca.SX, phase: PhaseRates, constraints: VirtualConstraints, second: ca.SX
) -> ca.SX:
    """Return w with y_a'' = w for every coordinate of y_a when its own error obeys the output dynamics, (n_a,).

    w = y_d'' - K_d (y_a' - y_d') - K_p (y_a - y_d) with y_d' = B' s' and y_d'' = B'' s'^2 + B' s''; the three curves
    share one product with their coefficients.

    Args:
        q: coordinates, (n_q,).
        v: their rates, (n_q,).
        phase: the phase variable there.
        constraints: gains and references.
        second: s'', 1/s^2; w grows with it along ``reference_slope``.
    """
    kp, kd = constraints.gains[0], constraints.gains[1]
    position = q.shape[0] - constraints.references.shape[0]  # of the base, which is not in y_a
    value, slope, curvature = _basis(phase.value, constraints)
    curve = curvature * phase.rate**2 + slope * second + kd * (slope * phase.rate) + kp * value
    return constraints.references @ curve - kd * v[position:] - kp * q[position:]


def reference_slope(phase: PhaseRates, constraints: VirtualConstraints) -> ca.SX:
    """Return B' = dy_d/ds, by which s'' enters the commanded acceleration, (n_a,)."""
    return constraints.references @ _basis(phase.value, constraints)[1]


def _basis(phase: ca.SX, constraints: VirtualConstraints) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Bernstein polynomials of the phase, with their first two derivatives, (order + 1,) each.

    Outside the phases that they are followed at they go on with their last second derivative, so that a late touchdown
    meets a twice differentiable reference instead of a polynomial far outside its range.
    """
    inside = ca.fmin(phase, LATEST_PHASE)
    if np.isfinite(constraints.phase.earliest):
        inside = ca.fmax(inside, constraints.phase.earliest)
    beyond = phase - inside
    order = constraints.references.shape[1] - 1
    value, slope, curvature = (ca.vertcat(*row) for row in bernstein_derivatives(order, inside))
    return value + slope * beyond + 0.5 * curvature * beyond**2, slope + curvature * beyond, curvature
