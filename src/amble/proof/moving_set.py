"""A set of states that moves with the flow, with the derivative of the way it came.

The starts are {c_0 + [-rho, rho]}, or {c_0 + B y, |y| <= rho}, of which y is called the start from here on. Where c_0
has come to lies in {c + sum_k L_k e_k} with an exact point c, exact matrices L_k and small boxes e_k, one for every
step; the derivative with respect to the start is V + sum_k L_k E_k with exact V and matrices of balls E_k; so every
start has come to c + sum L_k e_k + (V + sum L_k E_k) [-rho, rho] (mean value). A map with image of c in the box y, and
slope J = J_m + [-R, R] over the set, takes them to

    c' = mid y,   L_k' = mid(J_m L_k),   and a new term L' = 1,  e' = y - c' + [-R, R] sum L_k e_k,               (1)

and likewise V' = mid(J_m V), E' = [-R, R] (V + sum L_k E_k), with what rounding the products leaves. So what a step
misses is carried by products of exact matrices to the end, and no box is turned or wrapped on the way (Kuehn 1998,
Rigorously computed orbits of dynamical systems without the wrapping effect). Of more than ``MOST_TERMS`` the older half
is gathered in one box that follows an orthogonal factor (Lohner 1988).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from flint import arb, arb_mat

from amble.proof.arithmetic import column, exact_matrix, identity, largest, midpoints, symmetric
from amble.types import Matrix

MOST_TERMS = 48


@dataclass(frozen=True, kw_only=True)
class Term:
    """What one step missed, carried on.

    Attributes:
        carrier: L, exact.
        box: e, a column of balls.
        slope_box: E, balls.
    """

    carrier: arb_mat
    box: arb_mat
    slope_box: arb_mat


@dataclass(frozen=True, kw_only=True)
class MovingSet:
    """A set of states and the derivative of the map that made it.

    Attributes:
        radii: rho, balls about zero, one for every start coordinate.
        centre: c, n_x exact balls.
        slope: V, exact, a column for every start coordinate.
        terms: L_k, e_k, E_k, the oldest first.
        rounded: whether the starts are a ball, of the first radius in the Euclidean norm, and no box.
    """

    radii: list[arb]
    centre: list[arb]
    slope: arb_mat
    terms: tuple[Term, ...] = ()
    rounded: bool = False

    @classmethod
    def about(cls, centre: Sequence[arb], radii: Sequence[arb]) -> MovingSet:
        """Return the box about an exact centre, with the identity as the derivative."""
        return cls(radii=[symmetric(radius) for radius in radii], centre=list(centre), slope=identity(len(centre)))

    @classmethod
    def ball(cls, centre: Sequence[arb], off: Sequence[arb], basis: arb_mat, radius: arb) -> MovingSet:
        """Return the ball {c + B y, |y| <= radius} about points c that a box holds, with B as the derivative.

        Args:
            centre: exact.
            off: box that holds c - centre.
            basis: B, balls.
            radius: exact.
        """
        exact = basis.mid()
        term = Term(carrier=identity(len(centre)), box=column(off), slope_box=basis - exact)
        radii = [symmetric(radius)] * basis.ncols()
        return cls(radii=radii, centre=list(centre), slope=exact, terms=(term,), rounded=True)

    def hull(self) -> list[arb]:
        """Return a box that holds the set."""
        derivative = self.derivative()
        if self.rounded:
            lengths = [sum((value * value for value in row), start=arb(0)) for row in derivative.tolist()]
            around = [symmetric(length.abs_upper().sqrt()) * self.radii[0] for length in lengths]
        else:
            around = (derivative * column(self.radii)).entries()
        return [at + extra for at, extra in zip(self.middle(), around, strict=True)]

    def middle(self) -> list[arb]:
        """Return a box that holds where the centre of the starts has come to."""
        return [centre + extra for centre, extra in zip(self.centre, self._missed().entries(), strict=True)]

    def derivative(self) -> arb_mat:
        """Return a matrix of balls that holds the derivative at every start."""
        total = self.slope
        for term in self.terms:
            total = total + term.carrier * term.slope_box
        return total

    def moved(self, image: Sequence[arb], slope: arb_mat) -> MovingSet:
        """Apply a map by equation (1).

        Args:
            image: of c.
            slope: of the map over the whole set.
        """
        exact = slope.mid()
        wide = slope - exact
        centre = [value.mid() for value in image]
        box = column([value - middle for value, middle in zip(image, centre, strict=True)]) + wide * self._missed()
        product = exact * self.slope
        slope_box = product - product.mid() + wide * self.derivative()
        carried = []
        for term in _gathered(self.terms):
            whole = exact * term.carrier
            left = whole - whole.mid()
            box, slope_box = box + left * term.box, slope_box + left * term.slope_box
            carried.append(Term(carrier=whole.mid(), box=term.box, slope_box=term.slope_box))
        new = Term(carrier=identity(len(centre)), box=box, slope_box=slope_box)
        return replace(self, centre=centre, slope=product.mid(), terms=(*carried, new))

    def _missed(self) -> arb_mat:
        """Return sum L_k e_k as a column."""
        total = column([arb(0)] * len(self.centre))
        for term in self.terms:
            total = total + term.carrier * term.box
        return total


def _gathered(terms: tuple[Term, ...]) -> tuple[Term, ...]:
    """Return the terms, the older half in one where there are too many."""
    if len(terms) < MOST_TERMS:
        return terms
    old, young = terms[: MOST_TERMS // 2], terms[MOST_TERMS // 2 :]
    first = old[0].carrier
    basis = _orthogonal(midpoints(first), np.array([float(largest([value])) for value in old[0].box.entries()]))
    back = basis.inv()
    turned = [back * term.carrier for term in old]
    box, slope_box = turned[0] * old[0].box, turned[0] * old[0].slope_box
    for one, term in zip(turned[1:], old[1:], strict=True):
        box, slope_box = box + one * term.box, slope_box + one * term.slope_box
    return Term(carrier=basis, box=box, slope_box=slope_box), *young


def _orthogonal(matrix: Matrix, weights: Matrix) -> arb_mat:
    """Return an orthogonal matrix, rounded, that follows the columns in order of their weighted length."""
    lengths = np.linalg.norm(matrix, axis=0) * np.maximum(weights, np.finfo(float).tiny)
    factor, _ = np.linalg.qr(matrix[:, np.argsort(-lengths, kind="stable")])
    return exact_matrix(factor)
