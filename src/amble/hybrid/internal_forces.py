"""Contact forces that move nothing: the null space of the grasp map (docs/theory/allocation.md, eq. 4)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import casadi as ca

from amble.errors import InputError
from amble.numerics.linear_algebra import OrthogonalFactor, SymmetricFactor


def point_forces(feet: Sequence[ca.SX]) -> ca.SX:
    """Return W (3 n_c, k) for up to four point feet: k = 0, 0, 1, 3, 6.

    Two and three feet: internal forces [e; -e] along the lines between the feet. Four feet: those of the first
    three, and for each axis a unit force at the fourth foot with the smallest forces of the first three that balance
    it; the six along lines alone would lose one direction where four feet lie on a plane. The feet must not coincide,
    and three of them must not lie on a line.

    Args:
        feet: positions of the feet in the world frame, (3,) each, m.
    """
    columns = [_line_force(feet, a, b) for a, b in combinations(range(min(len(feet), 3)), 2)]
    if len(feet) == 4:
        columns.append(_balance(feet))
    return ca.horzcat(*columns) if columns else ca.SX(3 * len(feet), 0)


def grasp_map(wrenches: Sequence[ca.SX], feet: Sequence[ca.SX]) -> ca.SX:
    """Return the net force and the net moment about the first foot of all components, (6, n).

    Args:
        wrenches: force and moment at each foot of its components, world axes, (6, size) each.
        feet: positions of the feet, (3,) each, m.
    """
    columns = []
    for wrench, foot in zip(wrenches, feet, strict=True):
        force = ca.SX(wrench[:3, :])
        columns.append(ca.vertcat(force, wrench[3:, :] + ca.skew(foot - feet[0]) @ force))
    return ca.horzcat(*columns) if columns else ca.SX(6, 0)


def kernel_of_grasp(
    wrenches: Sequence[ca.SX], feet: Sequence[ca.SX], count: int, rows: Sequence[int] = range(6)
) -> ca.SX:
    """Return an orthonormal basis of the kernel of the grasp map, (n, count), by its orthogonal factor.

    Args:
        wrenches: as in ``grasp_map``.
        feet: as there.
        count: size of the basis.
        rows: of the map, all but those that are zero for every force.

    Raises:
        InputError: the rank of the grasp map is below its rows, where the factor has no use.
    """
    grasp = grasp_map(wrenches, feet)[list(rows), :]
    if grasp.shape[1] - count != grasp.shape[0]:
        raise InputError(
            f"{len(feet)} feet of this contact resist {grasp.shape[1] - count} of {len(rows)} directions of force and "
            "moment, for which their contact must give its own basis of internal forces"
        )
    return OrthogonalFactor.of(grasp).kernel


def _line_force(feet: Sequence[ca.SX], a: int, b: int) -> ca.SX:
    """Opposite forces of feet a and b along the line between them, proportional to its length."""
    column = ca.SX.zeros(3 * len(feet))
    line = feet[b] - feet[a]
    column[3 * a : 3 * a + 3] = line
    column[3 * b : 3 * b + 3] = -line
    return column


def _balance(feet: Sequence[ca.SX]) -> ca.SX:
    """Unit forces at the fourth foot, balanced by the first three: (12, 3)."""
    three = ca.horzcat(*[_grasp(foot - feet[3]) for foot in feet[:3]])
    fourth = _grasp(ca.SX.zeros(3))
    answer = -three.T @ SymmetricFactor.of(three @ three.T).solve(fourth)
    return ca.vertcat(answer, ca.SX.eye(3))


def _grasp(arm: ca.SX) -> ca.SX:
    """Force and moment about the reference of a force at the end of the arm: (6, 3)."""
    return ca.vertcat(ca.SX.eye(3), ca.skew(arm))
