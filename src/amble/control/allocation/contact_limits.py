"""How far torques and contact forces are from their limits: the numbers that say which limit is active or missed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca

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


def margins(feet: Sequence[str], forces: ca.SX, limits: ContactLimits) -> ca.SX:
    """Return the distance to the nearest friction and normal force limit, (2,), N; negative by how much it is missed.

    The entries are the minimum over the stance feet of mu f_z - |f_t| and of f_z - f_min (docs/theory/allocation.md,
    eq. 17).

    Args:
        feet: the stance feet; without any, nothing can be missed.
        forces: their contact forces, world frame, (3 n_c,), N.
        limits: friction and unilateral contact.
    """
    each = [forces[3 * i : 3 * i + 3] for i in range(len(feet))]
    if not each:
        return ca.SX([ca.inf, ca.inf])
    friction = [limits.friction * f[2] - ca.sqrt(f[0] ** 2 + f[1] ** 2) for f in each]
    normal = [f[2] - limits.normal_force for f in each]
    return ca.vertcat(ca.mmin(ca.vertcat(*friction)), ca.mmin(ca.vertcat(*normal)))


def torque_margin(torques: ca.SX, limits: ca.DM) -> ca.SX:
    """Return min_j 1 - |u_j| / u_max,j (docs/theory/allocation.md, eq. 17)."""
    return 1.0 - ca.norm_inf(torques / limits)
