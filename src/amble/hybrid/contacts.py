"""Contacts: these feet of a robot on this ground, with everything that follows for all of them together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from amble.hybrid.contact import POINT, Contact
from amble.hybrid.ground import FLAT, Ground
from amble.hybrid.internal_forces import grasp_map
from amble.robot import Robot, kinematics
from amble.robot.mirror import SignedPermutation
from amble.types import frozen

RANK_TOLERANCE = 1e-9
"""Singular values below this share of the largest count as zero in the rank of a grasp map or a contact Jacobian."""

SHARE = 1e-3
"""Weight of a row in a dependence, from which it is named."""


@dataclass(frozen=True)
class Contacts:
    """Some feet of a robot on the ground; immutable and hashable.

    Forces of all feet are stacked in the order of ``feet``, ``contact.size`` components each.

    Attributes:
        robot: the robot.
        feet: the feet, in the robot's foot order.
        contact: what each of them is; of a robot in the plane its likeness there.
        ground: what they stand on.
    """

    robot: Robot
    feet: tuple[str, ...]
    contact: Contact = POINT
    ground: Ground = FLAT

    def __post_init__(self) -> None:
        """Let the contact be that of the robot's base."""
        object.__setattr__(self, "contact", self.contact.on(self.robot.base))

    @property
    def size(self) -> int:
        """Number of force components and of constraint rows, n_f."""
        return self.contact.size * len(self.feet)

    @property
    def labels(self) -> tuple[str, ...]:
        """Foot and component of every entry, such as "fl x"."""
        return tuple(f"{foot} {label}" for foot in self.feet for label in self.contact.labels)

    def slice(self, foot: str) -> slice:
        """Where the components of a foot stand."""
        start = self.contact.size * self.feet.index(foot)
        return slice(start, start + self.contact.size)

    def normal_index(self, foot: str) -> int:
        """Place of the component that is a foot's normal force on level ground."""
        return self.slice(foot).start + len(self.contact.axes) - 1

    @property
    def every_foot(self) -> Contacts:
        """All feet of the robot."""
        return replace(self, feet=self.robot.foot_names)

    @property
    def columns(self) -> list[int]:
        """Where the entries stand among those of every foot."""
        whole = self.every_foot
        return [place for foot in self.feet for place in range(*whole.slice(foot).indices(whole.size))]

    def points(self, q: Any) -> ca.SX:
        """Return the positions of the feet, world frame, (3 n_c,), m."""
        return ca.vertcat(*[kinematics.foot_position(self.robot, foot, q) for foot in self.feet], ca.SX(0, 1))

    def jacobian(self, q: ca.SX) -> ca.SX:
        """Return the stacked constraint Jacobian J, (n_f, n_q)."""
        rows = [self.contact.jacobian(self.robot, foot, self.ground, q) for foot in self.feet]
        return ca.vertcat(*rows, ca.SX(0, self.robot.size))

    def dependent(self, q: tuple[float, ...]) -> tuple[str, ...]:
        """Return the labels of constraint rows that depend on each other at a configuration; none where J has rank n_f.

        Lengths are measured in leg lengths, so that a robot's size does not matter.

        Args:
            q: coordinates, (n_q,).
        """
        return _dependent(self, q)

    def bias(self, q: ca.SX, v: ca.SX) -> ca.SX:
        """Return the stacked (dJ/dt) v, (n_f,)."""
        rows = [self.contact.bias(self.robot, foot, self.ground, q, v) for foot in self.feet]
        return ca.vertcat(*rows, ca.SX(0, 1))

    def each(self, values: Any) -> list[Any]:
        """Split stacked components, (n_f, n), by foot."""
        return [values[self.slice(foot), :] for foot in self.feet]

    def frames(self, points: ca.SX) -> list[Any]:
        """Return the ground's frame under every foot, (3, 3) each."""
        return [self.ground.frame(points[3 * i : 3 * i + 3]) for i in range(len(self.feet))]

    def local(self, values: ca.SX, points: ca.SX) -> list[Any]:
        """Split stacked components by foot and turn them into the ground's frame, (size, n) each.

        Args:
            values: stacked components, (n_f, n).
            points: positions of the feet, (3 n_c,), m.
        """
        pairs = zip(self.each(values), self.frames(points), strict=True)
        return [self.contact.local(force, frame) for force, frame in pairs]

    def on_every_foot(self, forces: ca.SX) -> ca.SX:
        """Lay out the forces of all feet of the robot, zero where a foot is not on the ground."""
        zero = ca.SX.zeros(self.contact.size)
        return ca.vertcat(*[forces[self.slice(f)] if f in self.feet else zero for f in self.robot.foot_names])

    @property
    def internal_force_count(self) -> int:
        """Number k of independent internal forces: n_f less the rank of the grasp map, but at special postures."""
        return _internal_force_count(self)

    def internal_forces(self, points: ca.SX) -> ca.SX:
        """Return W: a basis of the forces with zero net force and moment, (n_f, k), N.

        Args:
            points: positions of the feet, (3 n_c,), m.
        """
        if not self.internal_force_count:
            return ca.SX(self.size, 0)
        feet = [points[3 * i : 3 * i + 3] for i in range(len(self.feet))]
        return self.contact.internal_forces(feet, self.frames(points), self.internal_force_count)

    def torque_null_space(self, q: ca.SX) -> tuple[ca.SX, ca.SX]:
        """Return the torques that cause no acceleration, (n_joints, k), and the internal forces that go with them.

        D a + h = B u + J^T lambda stays as it is where W s is added to lambda and -J_joints^T W s to u.

        Args:
            q: coordinates, (n_q,).

        Returns:
            N = -J_joints^T W, N m, and W of ``internal_forces``, (n_f, k), N.
        """
        joints = len(self.robot.joints)
        if not self.internal_force_count:
            return ca.SX(joints, 0), ca.SX(self.size, 0)
        force_basis = self.internal_forces(self.points(q))
        return -self.jacobian(q)[:, self.robot.size - joints :].T @ force_basis, force_basis

    @property
    def mirror(self) -> SignedPermutation:
        """The left-right mirror of the forces of every foot of the robot.

        Raises:
            InputError: the robot has no mirror.
        """
        robot, size = self.robot, self.contact.size
        order = [robot.foot_names.index(robot.mirror.feet[name]) for name in robot.foot_names]
        index = np.array([size * i + k for i in order for k in range(size)])
        return SignedPermutation(index, frozen(np.tile(self.contact.mirror_signs, len(order))))


@lru_cache(maxsize=256)
def _internal_force_count(contacts: Contacts) -> int:
    if not contacts.feet:
        return 0
    q = np.random.default_rng(0).uniform(-1.0, 1.0, contacts.robot.size)
    points = ca.SX(ca.DM(contacts.points(q)))
    wrenches = [contacts.contact.wrench(frame) for frame in contacts.frames(points)]
    feet = [points[3 * i : 3 * i + 3] for i in range(len(contacts.feet))]
    values = np.linalg.svd(np.asarray(ca.DM(grasp_map(wrenches, feet)).full()), compute_uv=False)
    return int(contacts.size - np.sum(values > RANK_TOLERANCE * values[0]))


@lru_cache(maxsize=256)
def _dependent(contacts: Contacts, q: tuple[float, ...]) -> tuple[str, ...]:
    if not contacts.feet:
        return ()
    jacobian = np.array(ca.DM(contacts.jacobian(ca.SX(ca.DM(q)))).full())
    jacobian[:, len(contacts.robot.base.axes) :] /= contacts.robot.leg_length
    left, values, _ = np.linalg.svd(jacobian)
    null = left[:, np.append(values, np.zeros(len(left) - len(values))) <= RANK_TOLERANCE * values[0]]
    return tuple(
        label for label, row in zip(contacts.labels, null, strict=True) if np.abs(row).max(initial=0.0) > SHARE
    )
