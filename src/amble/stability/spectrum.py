"""Multipliers of an orbit, with the symmetries of the system taken out on purpose.

Along a symmetry the map is neutral by construction: DP xi(x) = sigma xi(P(x)) with sigma = 1, or -1 where a reset
reverses the symmetry (a mirror and yaw); sigma is measured. At a relative fixed point P(x) = g x the reduced monodromy
M = (Dg)^-1 DP keeps the span of the generators. What remains is the map that M induces on the states modulo that span:
with Q an orthonormal basis of the span's complement its matrix is A = Q^T M Q, and the multipliers of the orbit are the
eigenvalues of A.

A conserved quantity I(P(x)) = I(x) is neutral too: grad I^T M = grad I^T, multiplier 1. M keeps the states of the same
value, so Q is taken within the kernel of the gradients, and A is the map among motions of the same value.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.hybrid import HybridSystem
from amble.stability.group import closest_shift, generators, gradients
from amble.stability.monodromy import monodromy
from amble.stability.poincare import TIME_LIMIT, TOLERANCE
from amble.types import Matrix, Vector, frozen


@dataclass(frozen=True)
class Neutral:
    """A symmetry or an invariant as it was measured.

    Attributes:
        name: of the symmetry or invariant.
        multiplier: sigma, measured; 1 or -1. Of an invariant 1.
        residual: |DP xi(x) - its part along the generators at P(x)| / |xi(x)|: how exactly the symmetry holds. Of an
            invariant |DP^T grad I(P(x)) - grad I(x)| / |grad I(x)|.
    """

    name: str
    multiplier: float
    residual: float


@dataclass(frozen=True)
class Spectrum:
    """The multipliers of an orbit modulo its symmetries, among motions with the same values of the invariants.

    Attributes:
        multipliers: eigenvalues of A, largest modulus first, (n,) with n = n_x - n_symmetries - n_invariants, complex.
            One of them is the 0 of the section (``poincare``).
        radius: largest modulus.
        neutral: the symmetries taken out.
        matrix: A.
        basis: Q, (n_x, n).
        conserved: the invariants taken out.
    """

    multipliers: NDArray[np.complex128]
    radius: float
    neutral: tuple[Neutral, ...]
    matrix: Matrix
    basis: Matrix
    conserved: tuple[Neutral, ...] = ()


def multipliers(
    system: HybridSystem,
    state: Vector,
    tolerance: float = TOLERANCE,
    time_limit: float = TIME_LIMIT,
    cycles: int = 1,
    max_step: float | None = None,
) -> Spectrum:
    """Return the multipliers of the orbit through a fixed point, by variational equations.

    Args:
        system: the system.
        state: the fixed point, (n_x,).
        tolerance: of the integrator.
        time_limit: the longest that one domain may last, s.
        cycles: of the orbit.
        max_step: the longest time between two looks at the guards, s (``simulate``).

    Raises:
        FallError: where the motion does not come back.
        InputError: where the symmetries are dependent or a function cannot be differentiated.
    """
    there = monodromy(system, state, tolerance, time_limit, cycles, max_step)
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
    kept, after = gradients(system, state), gradients(system, image)
    losses = np.linalg.norm(matrix.T @ after - kept, axis=0) / np.linalg.norm(kept, axis=0)
    conserved = tuple(
        Neutral(invariant.name, 1.0, float(loss)) for invariant, loss in zip(system.invariants, losses, strict=True)
    )
    taken = np.column_stack([xi, kept])
    basis = np.linalg.qr(taken, mode="complete")[0][:, taken.shape[1] :] if taken.shape[1] else np.eye(state.size)
    quotient = basis.T @ reduced @ basis
    values = np.linalg.eigvals(quotient).astype(np.complex128)
    ordered = values[np.argsort(-np.abs(values), kind="stable")]
    ordered.flags.writeable = False
    return Spectrum(
        multipliers=ordered,
        radius=float(np.abs(ordered[0])),
        neutral=neutral,
        matrix=frozen(quotient),
        basis=frozen(basis),
        conserved=conserved,
    )
