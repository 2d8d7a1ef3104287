"""Multipliers of an orbit, with the symmetries of the system taken out on purpose.

Along a symmetry the map is neutral by construction: DP xi(x) = sigma xi(P(x)) with sigma = 1, or -1 where a reset
reverses the symmetry (a mirror and yaw); sigma is measured. At a relative fixed point P(x) = g x the reduced monodromy
M = (Dg)^-1 DP keeps the span of the generators. What remains is the map that M induces on the states modulo that span:
with Q an orthonormal basis of the span's complement its matrix is A = Q^T M Q, and the multipliers of the orbit are the
eigenvalues of A.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.hybrid import HybridSystem
from amble.stability.group import closest_shift, generators
from amble.stability.monodromy import monodromy
from amble.stability.poincare import TIME_LIMIT, TOLERANCE
from amble.types import Matrix, Vector, frozen


@dataclass(frozen=True)
class Neutral:
    """A symmetry as it was measured.

    Attributes:
        name: of the symmetry.
        multiplier: sigma, measured; 1 or -1.
        residual: |DP xi(x) - its part along the generators at P(x)| / |xi(x)|: how exactly the symmetry holds.
    """

    name: str
    multiplier: float
    residual: float


@dataclass(frozen=True)
class Spectrum:
    """The multipliers of an orbit modulo its symmetries.

    Attributes:
        multipliers: eigenvalues of A, largest modulus first, (n_x - n_symmetries,), complex. One of them is the 0 of
            the section (``poincare``).
        radius: largest modulus.
        neutral: the symmetries taken out.
        matrix: A.
        basis: Q, (n_x, n_x - n_symmetries).
    """

    multipliers: NDArray[np.complex128]
    radius: float
    neutral: tuple[Neutral, ...]
    matrix: Matrix
    basis: Matrix


def multipliers(
    system: HybridSystem, state: Vector, tolerance: float = TOLERANCE, time_limit: float = TIME_LIMIT
) -> Spectrum:
    """Return the multipliers of the orbit through a fixed point, by variational equations.

    Args:
        system: the system.
        state: the fixed point, (n_x,).
        tolerance: of the integrator.
        time_limit: the longest that one domain may last, s.

    Raises:
        FallError: where the motion does not come back.
        InputError: where the symmetries are dependent or a function cannot be differentiated.
    """
    there = monodromy(system, state, tolerance, time_limit)
    return spectrum(system, state, there.image, there.matrix)


def spectrum(system: HybridSystem, state: Vector, image: Vector, matrix: Matrix) -> Spectrum:
    """Take the symmetries out of dP/dx at a relative fixed point and return what remains."""
    xi, moved = generators(system, state), generators(system, image)
    carried = matrix @ xi
    along = np.linalg.lstsq(moved, carried, rcond=None)[0]
    defects = np.linalg.norm(carried - moved @ along, axis=0) / np.linalg.norm(xi, axis=0)
    neutral = tuple(
        Neutral(symmetry.name, float(along[i, i]), float(defects[i])) for i, symmetry in enumerate(system.symmetries)
    )
    reduced = np.linalg.solve(closest_shift(system, state, image).matrix, matrix)
    basis = np.linalg.qr(xi, mode="complete")[0][:, xi.shape[1] :] if xi.shape[1] else np.eye(xi.shape[0])
    quotient = basis.T @ reduced @ basis
    values = np.linalg.eigvals(quotient).astype(np.complex128)
    ordered = values[np.argsort(-np.abs(values), kind="stable")]
    ordered.flags.writeable = False
    return Spectrum(ordered, float(np.abs(ordered[0])), neutral, frozen(quotient), frozen(basis))
