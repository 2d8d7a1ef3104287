"""How far torques and contact forces are from their limits: the numbers that say which limit is active or missed."""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca

from amble.control.allocation.law import finite
from amble.errors import InputError
from amble.hybrid import Contacts


@dataclass(frozen=True)
class ContactLimits:
    """Friction and unilateral contact of every stance foot.

    Attributes:
        friction: coefficient mu of the cone about the ground's normal, |f_t| <= mu f_n.
        normal_force: smallest f_n, N.

    Raises:
        InputError: where friction is not positive or the normal force is negative.
    """

    friction: float
    normal_force: float

    def __post_init__(self) -> None:
        """Refuse limits that no foot can keep."""
        if not finite("friction coefficient", self.friction) > 0.0:
            raise InputError(f"the friction coefficient is {self.friction}; it must be finite and positive")
        if not finite("smallest normal force", self.normal_force) >= 0.0:
            raise InputError(f"the smallest normal force is {self.normal_force} N; it must be finite and not negative")


def margins(contacts: Contacts, points: ca.SX, forces: ca.SX, limits: ContactLimits) -> ca.SX:
    """Return the distance to the nearest friction and normal force limit, (2,), N; negative by how much it is missed.

    The entries are the minimum over the stance feet of mu f_n - |f_t| and of f_n - f_min (docs/theory/allocation.md,
    eq. 17).

    Args:
        contacts: the stance feet; without any, nothing can be missed.
        points: their positions, world frame, (3 n_c,), m.
        forces: their contact forces, world frame, (n_f,), N.
        limits: friction and unilateral contact.
    """
    if not contacts.feet:
        return ca.SX([ca.inf, ca.inf])
    foot, each = contacts.contact, contacts.local(forces, points)
    friction = [limits.friction * foot.normal_force(f) - foot.tangential(f) for f in each]
    normal = [foot.normal_force(f) - limits.normal_force for f in each]
    return ca.vertcat(ca.mmin(ca.vertcat(*friction)), ca.mmin(ca.vertcat(*normal)))


def torque_margin(torques: ca.SX, limits: ca.DM) -> ca.SX:
    """Return min_j 1 - |u_j| / u_max,j (docs/theory/allocation.md, eq. 17)."""
    return 1.0 - ca.norm_inf(torques / limits)
