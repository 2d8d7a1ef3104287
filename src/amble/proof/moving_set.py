"""A set of states that moves with the flow, with the derivative of the way it came: Lohner's method.

The starts are {c_0 + [-rho, rho]}. Where c_0 has come to lies in {c + B e} with an exact point c, an exact
well-conditioned matrix B and a small box e; the derivative with respect to the start is V + Q E with exact V, Q and a
matrix of balls E; so every start has come to c + B e + (V + Q E) [-rho, rho] (mean value). A map with image of c in the
box y, and slope J over the set, takes them to

    c' = mid y,   e' = B'^-1 (J B) e + B'^-1 (y - c'),   B' = the orthogonal factor of mid(J B),                 (1)

columns ordered by the length of B e along them, and likewise V' = mid(J V), Q' from J Q (Lohner 1988; Nedialkov and
Jackson 1999, A new perspective on the wrapping effect). So the boxes turn with the flow and do not grow at each step.

Behind an impact J is singular. Directions that it does not reach are completed from those that it does: taken from the
factor as they come they would be rounding's, others in another precision, and a box would be another there.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from flint import arb, arb_mat

from amble.proof.arithmetic import column, exact_matrix, identity, midpoints, symmetric
from amble.types import Matrix

SPANNED = 1e-9
"""Share of a column's length that counts as none: rounding leaves 1e-13, and smaller true directions are no loss."""


@dataclass(frozen=True, kw_only=True)
class MovingSet:
    """A set of states and the derivative of the map that made it.

    Attributes:
        radii: rho, n_x balls.
        centre: c, n_x exact balls.
        basis: B.
        box: e, n_x balls.
        slope: V.
        slope_basis: Q.
        slope_box: E.
    """

    radii: list[arb]
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
            radii=[symmetric(radius) for radius in radii],
            centre=list(centre),
            basis=one,
            box=[arb(0)] * len(centre),
            slope=one,
            slope_basis=one,
            slope_box=one * arb(0),
        )

    def hull(self) -> list[arb]:
        """Return a box that holds the set."""
        around = (self.derivative() * column(self.radii)).entries()
        return [at + extra for at, extra in zip(self.middle(), around, strict=True)]

    def middle(self) -> list[arb]:
        """Return a box that holds where the centre of the starts has come to."""
        around = (self.basis * column(self.box)).entries()
        return [centre + extra for centre, extra in zip(self.centre, around, strict=True)]

    def derivative(self) -> arb_mat:
        """Return a matrix of balls that holds the derivative at every start."""
        return self.slope + self.slope_basis * self.slope_box

    def moved(self, image: Sequence[arb], slope: arb_mat) -> MovingSet:
        """Apply a map by equation (1).

        Args:
            image: of c.
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
            radii=self.radii,
            centre=centre,
            basis=basis,
            box=box.entries(),
            slope=kept,
            slope_basis=slope_basis,
            slope_box=back * (product - kept) + (back * turned) * self.slope_box,
        )


def _orthogonal(matrix: Matrix, weights: Matrix) -> arb_mat:
    """Return an orthogonal matrix, rounded, that follows the columns in order of their weighted length.

    A column that lies in the span of those before it gives no direction.
    """
    lengths = np.linalg.norm(matrix, axis=0) * np.maximum(weights, np.finfo(float).tiny)
    found = np.zeros((len(matrix), 0))
    for values in matrix[:, np.argsort(-lengths, kind="stable")].T:
        rest = values
        for _ in range(2):  # once more, for what rounding left
            rest = rest - found @ (found.T @ rest)
        size = np.linalg.norm(rest)
        if size > SPANNED * np.linalg.norm(values):
            found = np.column_stack([found, rest / size])
    factor, _ = np.linalg.qr(found, mode="complete")
    return exact_matrix(factor)


def _radii(matrix: arb_mat) -> Matrix:
    values = [float(value.abs_upper()) for value in matrix.entries()]
    return np.array(values).reshape(matrix.nrows(), matrix.ncols())
