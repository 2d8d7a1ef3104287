"""The smallest torques that keep torque limits, friction cones and unilateral contact, and those limits as rows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import casadi as ca

from amble.control.allocation.law import LawWithBreakpoints, Redundancy, effort_limits, finite, steered_joints
from amble.control.allocation.line import Interval, above, band, common, inside_cone, lowest_peak
from amble.errors import InputError
from amble.hybrid import Contacts
from amble.hybrid.contact import AXES
from amble.numerics.interior_point import QuadraticProgram, minimise

LEVEL = 1e-6
"""An internal force whose vertical part is smaller than this share of it does not steer normal forces."""

LOOSER = 1.01
"""Where the limits leave nothing, all are widened this much beyond the least that leaves something."""

DEEP = 0.1
"""The search for room among the limits stops at this relative depth."""


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


@dataclass(frozen=True)
class BoundedMinimumNorm(LawWithBreakpoints):
    """Minimise |u|^2 within limits (docs/theory/allocation.md, eq. 12 to 17 and 20).

    Torque limits are the effort limits of the robot's description. Two point feet: friction cones are exact, and the
    optimum is clipped on the line. More free directions: the pyramid inside the contact's cone, as a small quadratic
    program.

    Where no torque that realises the motion keeps all limits, the law falls back and ``diagnostics`` tells by how much
    each limit is missed. Two feet: torque limits come first (where they alone leave nothing, the smallest relative
    peak), then friction, then normal force, each kept as well as those before it allow. Three and more feet: the
    largest relative violation is as small as can be.

    Attributes:
        friction: coefficient mu.
        normal_force: smallest normal force of a stance foot, N.

    Raises:
        InputError: where friction is not positive or the normal force is negative.
    """

    units: ClassVar[Mapping[str, str]] = {"friction": "1", "normal_force": "N"}

    friction: float = 0.6
    normal_force: float = 0.0

    def __post_init__(self) -> None:
        """Refuse limits that no foot can keep."""
        self._contact()

    @property
    def name(self) -> str:
        """Name in files and on the command line."""
        return "bounded"

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Friction and the smallest normal force."""
        return {"friction": self.friction, "normal_force": self.normal_force}

    def diagnostics(self, redundancy: Redundancy, s: ca.SX) -> Mapping[str, ca.SX]:
        """Return ``margin``, (3,): distance to the torque, friction and normal force limits, negative where missed.

        The first is relative to the joint's limit, the others are in N (eq. 17).
        """
        effort = effort_limits(redundancy, range(len(redundancy.robot.joints)))
        torques = torque_margin(redundancy.torques + redundancy.torque_basis @ s, effort)
        forces = redundancy.forces + redundancy.force_basis @ s
        return {"margin": ca.vertcat(torques, margins(redundancy.contacts, redundancy.points, forces, self._contact()))}

    def _contact(self) -> ContactLimits:
        return ContactLimits(self.friction, self.normal_force)

    def on_line(self, redundancy: Redundancy) -> ca.SX:
        """Clip to normal forces, then friction, then torques; exact where they meet (eq. 16).

        Where contacts hold moments, or lie in a plane, the cones are not round and the program takes the place of the
        closed form.

        Raises:
            InputError: where a joint has no effort limit.
        """
        foot = redundancy.contacts.contact
        if foot.moments or len(foot.axes) < len(AXES):
            return self.in_space(redundancy)
        u, n = redundancy.torques, redundancy.torque_basis
        s = -ca.dot(n, u) / ca.dot(n, n)
        steers = [_zero_where_level(w) for w in redundancy.local(redundancy.force_basis)]
        pairs = list(zip(redundancy.local(redundancy.forces), steers, strict=True))
        s = common([above(f[2] - self.normal_force, e[2]) for f, e in pairs]).clip(s)
        s = common([inside_cone(f, e, self.friction) for f, e in pairs]).clip(s)
        return _torque_interval(redundancy).clip(s)

    def in_space(self, redundancy: Redundancy) -> ca.SX:
        """Several free directions: find how much the limits must give way, then the smallest torques (eq. 20).

        Raises:
            InputError: where a joint has no effort limit.
        """
        # shorthand
        N, k = redundancy.torque_basis, redundancy.size
        unit = ca.sqrt(ca.sum1(N**2)).T
        rows, limits = self._rows_in_space(redundancy)
        size = ca.mmax(effort_limits(redundancy, range(len(redundancy.robot.joints))))

        N = N / ca.repmat(unit.T, N.shape[0], 1)
        rows = rows * size / ca.repmat(unit.T, rows.shape[0], 1)
        count = rows.shape[0]
        room = QuadraticProgram(
            hessian=ca.diagcat(1e-9 * ca.SX.eye(k), ca.SX(1, 1)),
            cost=ca.vertcat(ca.SX.zeros(k), 1.0),
            rows=ca.blockcat([[rows, -ca.SX.ones(count)], [ca.SX(1, k), ca.SX(-1.0)]]),
            limits=ca.vertcat(limits, DEEP),
        )
        start = ca.vertcat(ca.SX.zeros(k), ca.fmax(-ca.mmin(limits), 0.0) + 1.0)
        missed = ca.fmax(minimise(room, start)[k], 0.0)
        least = QuadraticProgram(N.T @ N, N.T @ redundancy.torques / size, rows, limits + LOOSER * missed)
        return minimise(least, ca.SX.zeros(k)) * size / unit

    def _rows_in_space(self, redundancy: Redundancy) -> tuple[ca.SX, ca.SX]:
        """All limits as rows s <= limits; torques relative to their limit, forces to a foot's share of the weight."""
        joints = steered_joints(redundancy)
        effort = effort_limits(redundancy, joints)
        robot, feet = redundancy.robot, redundancy.feet
        share = robot.mass * robot.gravity / len(feet)
        u, N = redundancy.torques[joints] / effort, redundancy.torque_basis[joints, :] / effort
        rows, limits = [N, -N], [1.0 - u, 1.0 + u]
        foot = redundancy.contacts.contact
        forces, basis = (redundancy.local(part / share) for part in (redundancy.forces, redundancy.force_basis))
        for f, w in zip(forces, basis, strict=True):
            rows += [-foot.pyramid(w, self.friction), -foot.normal_force(w)]
            limits += [foot.pyramid(f, self.friction), foot.normal_force(f) - self.normal_force / share]
        return ca.vertcat(*rows), ca.vertcat(*limits)


def _torque_interval(redundancy: Redundancy) -> Interval:
    """Where all torques keep their limits; where they cannot, the smallest relative peak stands for it (eq. 12)."""
    joints = steered_joints(redundancy)
    effort = effort_limits(redundancy, joints)
    u, n = redundancy.torques[joints], redundancy.torque_basis[joints, 0]
    count = range(len(joints))
    inside = common([band(u[j], n[j], ca.SX(effort[j])) for j in count])
    return Interval(
        inside.lower, inside.upper, lowest_peak([u[j] / effort[j] for j in count], [n[j] / effort[j] for j in count])
    )


def _zero_where_level(direction: ca.SX) -> ca.SX:
    """The internal force of one foot without a vertical part that is only roundoff."""
    vertical = ca.if_else(ca.fabs(direction[2]) < LEVEL * ca.norm_2(direction), 0.0, direction[2])
    return ca.vertcat(direction[:2], vertical)
