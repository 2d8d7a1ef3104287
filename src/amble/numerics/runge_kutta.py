"""DOP853, the Runge-Kutta scheme of the simulation, as data that checks itself."""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np

from amble.errors import WorkError
from amble.types import Matrix, Vector, frozen

STAGES = 12
EXTENDED = 16
ROUNDOFF = 1e-13


@dataclass(frozen=True)
class Tableau:
    """Coefficients of the method.

    Attributes:
        a: row s holds the weights of stage s, (16, 16): rows 0 to 11 the step, row 12 its solution, 13 to 15 the
            stages that only the dense output needs.
        c: clocks of the stages as a share of the step, (16,).
        error3: weights of the error estimate of order 3, (13,).
        error5: weights of the error estimate of order 5, (13,).
        dense: weights of the four higher coefficients of the dense output, (4, 16).
    """

    a: Matrix
    c: Vector
    error3: Vector
    error5: Vector
    dense: Matrix

    def __post_init__(self) -> None:
        """Check the row sums, the quadrature conditions to order 8 and that the error estimates vanish on constants."""
        weights = self.a[STAGES, :STAGES]
        sums = [
            np.abs(self.a.sum(axis=1) - self.c).max(),
            *(abs(weights @ self.c[:STAGES] ** (k - 1) - 1.0 / k) for k in range(1, 9)),
            abs(self.error3.sum()),
            abs(self.error5.sum()),
            np.abs(np.triu(self.a)).max(),
        ]
        if not max(sums) < ROUNDOFF:
            raise WorkError(f"the coefficients of the integrator do not fit together (defect {max(sums):.1e})")


@functools.cache
def dop853() -> Tableau:
    """Return the coefficients of DOP853.

    Raises:
        WorkError: where the coefficients do not pass their own check.
    """
    from scipy.integrate import DOP853

    a, c = np.zeros((EXTENDED, EXTENDED)), np.zeros(EXTENDED)
    a[:STAGES, :STAGES] = DOP853.A[:STAGES, :STAGES]
    a[STAGES, :STAGES] = DOP853.B
    a[STAGES + 1 :] = DOP853.A_EXTRA
    c[:STAGES], c[STAGES], c[STAGES + 1 :] = DOP853.C[:STAGES], 1.0, DOP853.C_EXTRA
    return Tableau(frozen(a), frozen(c), frozen(DOP853.E3), frozen(DOP853.E5), frozen(DOP853.D))
