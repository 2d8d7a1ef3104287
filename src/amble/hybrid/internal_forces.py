"""Contact forces that move nothing: the null space of the grasp map (docs/theory/allocation.md, eq. 4)."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import combinations

import casadi as ca

from amble.errors import InputError
from amble.numerics.linear_algebra import OrthogonalFactor


def point_forces(feet: Sequence[ca.SX]) -> ca.SX:
    """Return W (3 n_c, k) for up to three point feet: k = 0, 0, 1, 3.

    They are forces [e; -e] along the lines between the feet, which must not coincide nor lie on one line. The six of
    four feet would lose one direction where these lie on a plane: more feet take ``kernel_of_grasp``, which only needs
    three feet, any of them, off one line.

    Args:
        feet: positions of the feet in the world frame, (3,) each, m.
    """
    columns = [_line_force(feet, a, b) for a, b in combinations(range(len(feet)), 2)]
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
