"""How far the spectral radius of a matrix can move under a perturbation of about known size: an estimate."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amble.stability.lyapunov import accumulated
from amble.types import Matrix, Vector

ANGLES = 181
BISECTIONS = 40
LIFT, SMALLEST = 1.1, 1e-4
"""How far above the radius the Lyapunov function is asked for, and its least value relative to the norm."""

WORST_CONDITION = 1e12
"""Coordinates whose Lyapunov function is worse conditioned than this are not used."""


def radius(matrix: Matrix) -> float:
    """Spectral radius."""
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def largest_radius(matrix: Matrix, doubts: Sequence[Matrix]) -> float:
    """Estimate the largest spectral radius of a matrix that is known up to some perturbations.

    The estimate is the pseudospectral radius for the sum of the norms of the perturbations: no perturbation of that
    size gives more, but the sizes themselves are measured. This is so in any coordinates, and a return map is far from
    normal in those of the states (positions beside velocities, multipliers near 0), so it is taken in three, and the
    smallest one counts: as given, balanced, and where a quadratic Lyapunov function of A / r, with r a little above the
    radius, is the square of the norm, so that the norm of A is about its radius.

    Args:
        matrix: A.
        doubts: matrices whose sizes measure how well A is known.
    """
    estimates = []
    for forward, back in _coordinates(matrix):
        size = sum(float(np.linalg.norm(forward @ doubt @ back, 2)) for doubt in doubts)
        estimates.append(pseudospectral_radius(forward @ matrix @ back, size))
    return min(estimates)


def _coordinates(matrix: Matrix) -> list[tuple[Matrix, Matrix]]:
    """Return changes of coordinates with their inverses: none, balanced, and balanced with a Lyapunov function."""
    from scipy.linalg import matrix_balance

    identity = np.eye(len(matrix))
    balanced, (scales, _) = matrix_balance(matrix, permute=False, separate=True)
    found = [(identity, identity), (np.diag(1.0 / scales), np.diag(scales))]
    reached = max(LIFT * radius(matrix), SMALLEST * float(np.linalg.norm(balanced, 2)))
    if reached > 0:
        weight = accumulated(balanced / reached)
        if np.all(np.isfinite(weight)) and np.linalg.cond(weight) < WORST_CONDITION:
            forward = np.linalg.cholesky(weight).T
            found.append((forward / scales, scales[:, np.newaxis] * np.linalg.inv(forward)))
    return found


def pseudospectral_radius(matrix: Matrix, size: float) -> float:
    """Return the largest modulus that an eigenvalue of ``matrix + E`` takes over all E with 2-norm up to ``size``.

    It is the largest |z| with smin(z 1 - A) <= size (Trefethen and Embree, Spectra and Pseudospectra, theorem 2.1 and
    section 2), found by bisection in |z| over angles that include those of the eigenvalues; unlike condition numbers
    of eigenvalues it holds for defective matrices too, and a Poincare map is defective at 0. Between the angles nothing
    is looked at, so that the result may be a little too small.

    Args:
        matrix: A, square and real.
        size: of the perturbation, at least 0.
    """
    values = np.linalg.eigvals(matrix)
    angles = np.unique(np.concatenate([np.linspace(0.0, np.pi, ANGLES), np.abs(np.angle(values))]))
    low = float(np.abs(values).max())
    if size == 0.0:
        return low
    high = float(np.linalg.norm(matrix, 2)) + size
    floor = low
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if _smallest(matrix, middle, angles) <= size:
            low = middle
        else:
            high = middle
        if high - low <= 1e-3 * max(high - floor, 1e-15):
            break
    return high


def _smallest(matrix: Matrix, modulus: float, angles: Vector) -> float:
    """Smallest singular value of z 1 - A over |z| = modulus; the lower half circle mirrors the upper one."""
    shifted = modulus * np.exp(1j * angles)[:, np.newaxis, np.newaxis] * np.eye(len(matrix)) - matrix
    return float(np.linalg.svd(shifted, compute_uv=False)[:, -1].min())
