"""The numbers of a gait's virtual constraints, as its closed loop takes them."""

from __future__ import annotations

from amble.control.outputs import LARGEST_ORDER, selection_matrix
from amble.control.virtual_constraints import pack
from amble.gait.record import Gait
from amble.numerics.bezier import elevate
from amble.types import Matrix, Vector, frozen

REFERENCE_ORDER = LARGEST_ORDER
"""Order of the reference curves in the compiled loop: lower orders are written exactly in it, and the base's own
motion over a domain is met to about 1e-9."""


def numbers_of(gait: Gait, domain: str) -> tuple[float, Matrix, Matrix, Vector]:
    """Return duration (s), references (n_a, order + 1), weights (n_y, n_a) and numbers of the phase (k,)."""
    if gait.feedback is not None:
        feedback = gait.feedback
        numbers = feedback.phase_numbers.get(domain, frozen([]))
        return feedback.durations[domain], feedback.references[domain], feedback.weights[domain], numbers
    trajectory = next(part for part in gait.domains if part.name == domain)
    weights = selection_matrix(gait.robot, gait.outputs.of(domain))
    return trajectory.duration, weights.T @ trajectory.coefficients, weights, trajectory.phase_numbers


def loop_parameters(gait: Gait, domain: str) -> Vector:
    """Pack the numbers of a domain's virtual constraints as ``VirtualConstraints.packed`` does."""
    duration, references, weights, numbers = numbers_of(gait, domain)
    return frozen(pack(duration, gait.gains, elevate(references, REFERENCE_ORDER), weights, numbers))
