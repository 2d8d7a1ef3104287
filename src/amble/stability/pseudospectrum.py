"""How far the spectral radius of a matrix can move under a perturbation of known size."""

from __future__ import annotations

import numpy as np

from amble.types import Matrix, Vector

ANGLES = 181
BISECTIONS = 40


def radius(matrix: Matrix) -> float:
    """Spectral radius."""
    return float(np.abs(np.linalg.eigvals(matrix)).max())


def pseudospectral_radius(matrix: Matrix, size: float) -> float:
    """Return the largest modulus that an eigenvalue of ``matrix + E`` takes over all E with 2-norm up to ``size``.

    It is the largest |z| with smin(z 1 - A) <= size (Trefethen and Embree, Spectra and Pseudospectra, theorem 2.1 and
    section 2), found by bisection in |z| over angles that include those of the eigenvalues; unlike condition numbers
    of eigenvalues it holds for defective matrices too, and a Poincare map is defective at 0.

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
