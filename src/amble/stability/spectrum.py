"""Multipliers of an orbit, with the symmetries of the system taken out on purpose, and how far they can move.

Along a symmetry the map is neutral by construction: DP xi(x) = sigma xi(P(x)) with sigma = 1, or -1 where a reset
reverses the symmetry (a mirror and yaw); sigma is measured. Where a reset turns the state (a gait with a yaw rate)
translations are mixed, and sigma is the cosine of the turn. At a relative fixed point P(x) = g x the reduced monodromy
M = (Dg)^-1 DP keeps the span of the generators. What remains is the map that M induces on the states modulo that span:
with Q an orthonormal basis of the span's complement its matrix is A = Q^T M Q, and the multipliers of the orbit are the
eigenvalues of A.

A conserved quantity I(P(x)) = I(x) is neutral too: grad I^T M = grad I^T, multiplier 1. M keeps the states of the same
value, so Q is taken within the kernel of the gradients, and A is the map among motions of the same value.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.hybrid import HybridSystem
from amble.stability.group import closest_shift, generators, gradients
from amble.stability.lyapunov import accumulated
from amble.stability.monodromy import monodromy
from amble.stability.poincare import TIME_LIMIT, TOLERANCE
from amble.types import Matrix, Vector, frozen

ANGLES = 181
BISECTIONS = 40
LIFT, SMALLEST = 1.1, 1e-4
"""How far above the radius the Lyapunov function is asked for, and its least value relative to the norm."""

WORST_CONDITION = 1e12
"""Coordinates whose Lyapunov function is worse conditioned than this are not used."""


@dataclass(frozen=True)
class Neutral:
    """A symmetry or an invariant as it was measured.

    Attributes:
        name: of the symmetry or invariant.
        multiplier: sigma, measured; 1 or -1, of translations that a reset turns the cosine. Of an invariant 1.
        residual: |DP xi(x) - its part along the generators at P(x)| / |xi(x)|: how exactly the symmetry holds. Of an
            invariant |DP^T grad I(P(x)) - grad I(x)| / |grad I(x)|.
    """

    name: str
    multiplier: float
    residual: float


@dataclass(frozen=True, kw_only=True)
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
        max_step: the longest time between two event samples, s (``simulate``).

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
    circles, floor, step = _Circles(matrix, size, angles, low, high), low, size
    while low + step < high and circles.attain(low + step):  # most often the radius is near, and the norm far
        step *= 4.0
    for _ in range(BISECTIONS):
        middle = 0.5 * (low + high)
        if circles.attain(middle):
            low = middle
        else:
            high = middle
        if high - low <= 1e-3 * max(high - floor, 1e-15):
            break
    return high


class _Circles:
    """Which circles |z| = modulus the pseudospectrum reaches: all up to one, as each of its parts has an eigenvalue."""

    def __init__(self, matrix: Matrix, size: float, angles: Vector, inside: float, outside: float) -> None:
        self._matrix, self._size, self._angles = matrix, size, angles
        self._inside, self._outside, self._reached = inside, outside, inside
        self._below = np.full(angles.size, -np.inf)  # a lower bound of smin(z 1 - A) at every angle

    def attain(self, modulus: float) -> bool:
        """Whether smin(z 1 - A) <= size at one of the angles."""
        if not self._inside < modulus < self._outside:
            return modulus <= self._inside
        self._below -= abs(modulus - self._reached)  # smin(z 1 - A) changes by |z - z'| at most
        self._reached = modulus
        found = self._looked(modulus)
        self._inside, self._outside = (modulus, self._outside) if found else (self._inside, modulus)
        return found

    def _looked(self, modulus: float) -> bool:
        """Look at the angles of the least bounds first: where smin was small it is most often small again."""
        doubtful, count = np.flatnonzero(self._below <= self._size), 1
        doubtful = doubtful[np.argsort(self._below[doubtful], kind="stable")]
        while doubtful.size:
            now, doubtful = doubtful[:count], doubtful[count:]
            self._below[now] = _smallest(self._matrix, modulus, self._angles[now])
            if np.any(self._below[now] <= self._size):
                return True
            count *= 4
        return False


def _smallest(matrix: Matrix, modulus: float, angles: Vector) -> Vector:
    """Smallest singular values of z 1 - A over |z| = modulus, (k,); the lower half circle mirrors the upper one."""
    shifted = modulus * np.exp(1j * angles)[:, np.newaxis, np.newaxis] * np.eye(len(matrix)) - matrix
    return np.asarray(np.linalg.svd(shifted, compute_uv=False)[:, -1])
