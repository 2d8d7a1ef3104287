"""How far torques and contact forces are from their limits: the numbers that say which limit is active or missed."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation.law import Redundancy, effort_limits
from amble.errors import InputError


@dataclass(frozen=True)
class ContactLimits:
    """Friction and unilateral contact of every stance foot, in the world frame, on ground that may lie at any height.

    Attributes:
        friction: coefficient mu of the upright cone |f_t| <= mu f_z.
        normal_force: smallest f_z, N.

    Raises:
        InputError: where friction is not positive or the normal force is negative.
    """

    friction: float
    normal_force: float

    def __post_init__(self) -> None:
        """Refuse limits that no foot can keep."""
        if not 0.0 < self.friction < float("inf"):
            raise InputError(f"the friction coefficient is {self.friction}; it must be finite and positive")
        if not 0.0 <= self.normal_force < float("inf"):
            raise InputError(f"the smallest normal force is {self.normal_force} N; it must be finite and not negative")


MARGINS = ("torque", "friction", "normal force")
"""Names of the entries of ``margins``, in order; the first is relative to the joint's limit, the others in N."""


def margins(redundancy: Redundancy, s: ca.SX, limits: ContactLimits) -> ca.SX:
    """Return the distance to the nearest limit of each kind, (3,); negative by how much one is missed.

    The entries are min_j 1 - |u_j| / u_max,j, then min over the stance feet of mu f_z - |f_t| and of f_z - f_min
    (docs/theory/allocation.md, eq. 17).

    Args:
        redundancy: all torques and forces of the motion.
        s: the choice among them, (k,).
        limits: friction and unilateral contact.

    Raises:
        InputError: where a joint has no effort limit.
    """
    u = redundancy.torques + redundancy.null @ s
    forces = redundancy.forces + redundancy.squeeze @ s
    limit = effort_limits(redundancy, range(len(redundancy.robot.joints)))
    feet = [forces[3 * i : 3 * i + 3] for i in range(len(redundancy.feet))]
    friction = [limits.friction * f[2] - ca.sqrt(f[0] ** 2 + f[1] ** 2) for f in feet]
    normal = [f[2] - limits.normal_force for f in feet]
    nothing = [ca.SX(ca.inf)]
    return ca.vertcat(
        1.0 - ca.norm_inf(u / limit),
        ca.mmin(ca.vertcat(*(friction or nothing))),
        ca.mmin(ca.vertcat(*(normal or nothing))),
    )
