"""A set of states that moves with the flow, with the derivative of the way it came: Lohner's method.

The set is {c + B r} with an exact centre c, an exact well-conditioned matrix B and a box r; the derivative with respect
to the start is V + Q E with exact V, Q and a matrix of balls E. A map with image of the centre y and slope J over the
set takes them to

    c' = mid y,   r' = B'^-1 (J B) r + B'^-1 (y - c'),   B' = the orthogonal factor of mid(J B),                 (1)

columns ordered by the length of B r along them, and likewise V' = mid(J V), Q' from J Q (Lohner 1988; Nedialkov and
Jackson 1999, A new perspective on the wrapping effect). So the box turns with the flow instead of growing at each step.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat

from amble.proof.arithmetic import column, exact_matrix, identity, midpoints, symmetric
from amble.types import Matrix


@dataclass(frozen=True, kw_only=True)
class MovingSet:
    """A set of states and the derivative of the map that made it.

    Attributes:
        centre: c, n_x exact balls.
        basis: B.
        box: r, n_x balls.
        slope: V.
        slope_basis: Q.
        slope_box: E.
    """

    centre: list[arb]
    basis: arb_mat
    box: list[arb]
    slope: arb_mat
    slope_basis: arb_mat
    slope_box: arb_mat

    @classmethod
    def about(cls, centre: Sequence[arb], radii: Sequence[arb]) -> MovingSet:
        """Return the box about an exact centre, with the identity as the derivative."""
        one = identity(len(centre))
        return cls(
            centre=list(centre),
            basis=one,
            box=[symmetric(radius) for radius in radii],
            slope=one,
            slope_basis=one,
            slope_box=one * arb(0),
        )

    def hull(self) -> list[arb]:
        """Return a box that holds the set."""
        around = (self.basis * column(self.box)).entries()
        return [centre + extra for centre, extra in zip(self.centre, around, strict=True)]

    def derivative(self) -> arb_mat:
        """Return a matrix of balls that holds the derivative at every start."""
        return self.slope + self.slope_basis * self.slope_box

    def moved(self, image: Sequence[arb], slope: arb_mat) -> MovingSet:
        """Apply a map by equation (1).

        Args:
            image: of the centre.
            slope: of the map over the whole set.
        """
        carried = slope * self.basis
        basis = _orthogonal(midpoints(carried), np.array([float(r.abs_upper()) for r in self.box]))
        inverse = basis.inv()
        centre = [value.mid() for value in image]
        rest = column([value - middle for value, middle in zip(image, centre, strict=True)])
        box = (inverse * carried) * column(self.box) + inverse * rest

        product, turned = slope * self.slope, slope * self.slope_basis
        kept = product.mid()
        sizes = np.abs(_radii(self.slope_box)).max(axis=1)
        slope_basis = _orthogonal(midpoints(turned), sizes)
        back = slope_basis.inv()
        return MovingSet(
            centre=centre,
            basis=basis,
            box=box.entries(),
            slope=kept,
            slope_basis=slope_basis,
            slope_box=back * (product - kept) + (back * turned) * self.slope_box,
        )


def _orthogonal(matrix: Matrix, weights: Matrix) -> arb_mat:
    """Return an orthogonal matrix, rounded, that follows the columns in order of their weighted length."""
    lengths = np.linalg.norm(matrix, axis=0) * np.maximum(weights, np.finfo(float).tiny)
    factor, _ = np.linalg.qr(matrix[:, np.argsort(-lengths, kind="stable")])
    return exact_matrix(factor)


def _radii(matrix: arb_mat) -> Matrix:
    values = [float(value.abs_upper()) for value in matrix.entries()]
    return np.array(values).reshape(matrix.nrows(), matrix.ncols())
