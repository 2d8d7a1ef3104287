"""How much a disturbance can grow before it decays: the largest norm of a power of the return map."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.stability.spectrum import Spectrum
from amble.types import Matrix, Vector

MOST_CYCLES = 100_000
"""Powers that are looked at; a radius of 0.9999 needs fewer."""


@dataclass(frozen=True)
class Growth:
    """max over k of ||A^k||, k from 1: the factor, 1 or less where nothing grows, and the k."""

    factor: float
    cycles: int


def growth(matrix: Matrix) -> Growth:
    """Find the largest 2-norm of the powers of a matrix with spectral radius below 1.

    Once ||A^k|| < 1 nothing larger follows: with n = q k + j, ||A^n|| <= ||A^k||^q ||A^j||, and the largest of the
    first k powers has been seen. So the search ends there.

    Args:
        matrix: A.
    """
    power, best, at = matrix, float(np.linalg.norm(matrix, 2)), 1
    size = best
    for cycles in range(2, MOST_CYCLES + 1):
        if size < 1.0:
            break
        power = power @ matrix
        size = float(np.linalg.norm(power, 2))
        if size > best:
            best, at = size, cycles
    return Growth(best, at)


def in_units(spectrum: Spectrum, units: Vector) -> Matrix:
    """Return the reduced return map where a state is measured by its unit and a deviation modulo the symmetries.

    The norm of a deviation is then the least that any shift along the symmetries leaves of it.

    Args:
        spectrum: A in its basis Q.
        units: how large a change of each state counts as one, (n_x,).

    Returns:
        T A T^-1 with T = Q_s^T S Q, S the division by the units and Q_s an orthonormal basis of the complement of the
        scaled generators, (m, m).
    """
    size, kept = spectrum.basis.shape
    whole = np.linalg.qr(spectrum.basis, mode="complete")[0]
    generators = whole[:, kept:] / units[:, np.newaxis]
    scaled = np.linalg.qr(generators, mode="complete")[0][:, size - kept :] if kept < size else np.eye(size)
    change = scaled.T @ (spectrum.basis / units[:, np.newaxis])
    return np.asarray(change @ spectrum.matrix @ np.linalg.inv(change))
