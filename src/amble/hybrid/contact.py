"""Contact: what a foot on the ground is; it neither slips nor sinks, its forces lie in a cone (paper, section 2)."""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from math import sqrt
from typing import Any

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.hybrid.ground import CASADI, Ground, components, into_frame
from amble.hybrid.internal_forces import kernel_of_grasp, point_forces
from amble.io.registry import Registry
from amble.robot import Robot, kinematics
from amble.robot.base import PLANE, Base
from amble.types import NodeValues

AXES = ("x", "y", "z")

FORCE_SIGNS = (1.0, -1.0, 1.0)
"""A mirrored force has its y component reversed."""

QUANTITIES: Mapping[str, str] = {"normal force": "N", "friction": "1", "height": "m", "drift": "m", "slip": "m/s"}
"""Quantities of a contact and their units.

- normal force: of a stance foot, along the ground's normal.
- friction: what a stance foot uses of the cone: its tangential load over its normal force.
- height: distance of a swing foot from the ground along the normal.
- drift: distance of a stance foot from where its stance phase began.
- slip: speed of a stance foot.
"""


class Contact(ABC):
    """A foot that sticks to the ground at a point and may hold moments there; immutable and hashable.

    The force of a foot has ``size`` components: the force along the world's x, y and z, then moments about
    ``moment_axes``. The constraint rows are their duals: the velocity of the point, then its angular velocity about
    these axes. "Local" components have the force along the ground's two tangents and its normal. A contact in the
    plane of x and z has no components along y.
    """

    @property
    @abstractmethod
    def name(self) -> str:
        """Short name of the kind, as used in files."""

    @property
    def parameters(self) -> Mapping[str, Any]:
        """Parameters as plain JSON values; with the name they rebuild the contact."""
        return {}

    @property
    def axes(self) -> tuple[int, ...]:
        """World axes of the force: 0, 1, 2 for x, y, z."""
        return (0, 1, 2)

    def on(self, base: Base) -> Contact:
        """Return what this is for a robot with a base: itself in space, its likeness in the plane.

        Raises:
            InputError: there is none.
        """
        if base.axes != self.axes:
            raise InputError(f"contact '{self.name}' is none of a robot whose base moves in {base.name}")
        return self

    @property
    def moments(self) -> tuple[str, ...]:
        """Labels of the moments; none by default."""
        return ()

    @property
    def moment_signs(self) -> tuple[float, ...]:
        """Signs of the moments under the mirror y -> -y; a moment about the normal is reversed."""
        return ()

    def moment_axes(self, frame: Any) -> Any:
        """Return the axes of the moments in world axes as columns, (3, moments).

        Args:
            frame: the ground's tangents and normal as columns, (3, 3).
        """
        del frame
        return ca.SX(3, 0)

    @abstractmethod
    def tangential(self, local: Any) -> Any:
        """Return the load that friction carries, N: it may be as large as mu times the normal force (the exact cone).

        Args:
            local: local components, casadi (size, n) or numpy (..., size).
        """

    @property
    @abstractmethod
    def sides(self) -> tuple[str, ...]:
        """Labels of the rows of ``pyramid``."""

    @abstractmethod
    def pyramid(self, local: Any, friction: Any) -> ca.SX:
        """Return rows linear in the force that are not negative inside a pyramid within the cone, (sides, n), N.

        Args:
            local: local components, (size, n).
            friction: coefficient mu.
        """

    @property
    def labels(self) -> tuple[str, ...]:
        """Labels of the components of the force, and of the constraint rows."""
        return (*(AXES[axis] for axis in self.axes), *self.moments)

    @property
    def size(self) -> int:
        """Number of components."""
        return len(self.labels)

    def component_units(self, along: str, about: str) -> list[str]:
        """Return a unit of every component: one of forces or points, one of moments or turns."""
        return [along] * len(self.axes) + [about] * len(self.moments)

    @property
    def mirror_signs(self) -> tuple[float, ...]:
        """Signs of the components under the mirror y -> -y."""
        return (*(FORCE_SIGNS[axis] for axis in self.axes), *self.moment_signs)

    def jacobian(self, robot: Robot, foot: str, ground: Ground, q: ca.SX) -> ca.SX:
        """Return J with J v = 0 for a foot that sticks, (size, n_q)."""
        point = kinematics.foot_jacobian(robot, foot, q)[list(self.axes), :]
        if not self.moments:
            return point
        axes = self.moment_axes(ground.frame(kinematics.foot_position(robot, foot, q)))
        return ca.vertcat(point, axes.T @ kinematics.foot_rotation_jacobian(robot, foot, q))

    def bias(self, robot: Robot, foot: str, ground: Ground, q: ca.SX, v: ca.SX) -> ca.SX:
        """Return (dJ/dt) v, (size,)."""
        point = kinematics.foot_bias(robot, foot, q, v)[list(self.axes)]
        if not self.moments:
            return point
        turned = self.jacobian(robot, foot, ground, q)[len(self.axes) :, :] @ v
        return ca.vertcat(point, ca.jtimes(turned, q, v))

    def wrench(self, frame: Any) -> ca.SX:
        """Return the force and the moment about the foot that unit components make, world axes, (6, size)."""
        return ca.diagcat(ca.SX.eye(len(AXES))[:, list(self.axes)], self.moment_axes(frame))

    def local(self, force: Any, frame: Any) -> Any:
        """Turn components into local ones, casadi (size, n) or numpy (..., size)."""
        axes, count = list(self.axes), len(self.axes)
        if isinstance(force, CASADI):
            turned = frame if count == len(AXES) else frame[axes, axes]
            return ca.vertcat(into_frame(force[:count, :], turned), force[count:, :])
        turned = frame if count == len(AXES) else np.asarray(frame)[..., axes, :][..., axes]
        return np.concatenate([into_frame(force[..., :count], turned), force[..., count:]], axis=-1)

    def normal_force(self, local: Any) -> Any:
        """Return the force along the ground's normal, N."""
        return components(local)[len(self.axes) - 1]

    def friction_used(self, local: NodeValues) -> NodeValues:
        """Return tangential load over normal force, 1; infinite for a foot that does not push: no friction holds it."""
        normal, load = self.normal_force(local), self.tangential(local)
        pushes = normal > 0.0
        return np.where(pushes, load / np.where(pushes, normal, 1.0), np.inf)

    def internal_forces(self, points: Sequence[ca.SX], frames: Sequence[Any], count: int) -> ca.SX:
        """Return a basis of the forces of all feet with zero net force and moment, (feet size, count).

        Args:
            points: positions of the feet, world axes, (3,) each.
            frames: the ground's frames there, (3, 3) each.
            count: how many such forces there are.
        """
        return kernel_of_grasp([self.wrench(frame) for frame in frames], points, count)


@dataclass(frozen=True)
class PointContact(Contact):
    """A point that holds three forces and no moment, in the cone |f_t| <= mu f_n."""

    @property
    def name(self) -> str:
        """Name in files."""
        return "point"

    def tangential(self, local: Any) -> Any:
        """Return |f_t|."""
        x, y, *_ = components(local)
        return (x**2 + y**2) ** 0.5

    @property
    def sides(self) -> tuple[str, ...]:
        """One along each direction of both tangents."""
        return ("+x", "-x", "+y", "-y")

    def pyramid(self, local: Any, friction: Any) -> ca.SX:
        """|f_1|, |f_2| <= mu f_n / sqrt(2): the largest square pyramid inside the cone."""
        x, y, normal, *_ = components(local)
        inner = friction / sqrt(2.0)
        return ca.vertcat(inner * normal - x, inner * normal + x, inner * normal - y, inner * normal + y)

    def on(self, base: Base) -> Contact:
        """Return itself, or the point in the plane."""
        return self if base.in_space else PLANAR_POINT

    def internal_forces(self, points: Sequence[ca.SX], frames: Sequence[Any], count: int) -> ca.SX:
        """Closed forms for up to three feet, the kernel of the grasp map for more."""
        return point_forces(points) if len(points) <= 3 else super().internal_forces(points, frames, count)


@dataclass(frozen=True)
class PlanarPointContact(Contact):
    """A point of a robot in the plane of x and z: two forces, in the cone |f_t| <= mu f_n."""

    @property
    def name(self) -> str:
        """Name in files."""
        return "planar point"

    @property
    def axes(self) -> tuple[int, ...]:
        """X and z."""
        return PLANE.axes

    def tangential(self, local: Any) -> Any:
        """Return |f_t|."""
        along = components(local)[0]
        return (along**2) ** 0.5

    @property
    def sides(self) -> tuple[str, ...]:
        """Forwards and backwards."""
        return ("+x", "-x")

    def pyramid(self, local: Any, friction: Any) -> ca.SX:
        """|f_t| <= mu f_n: the cone itself."""
        along, normal = components(local)
        return ca.vertcat(friction * normal - along, friction * normal + along)

    def internal_forces(self, points: Sequence[ca.SX], frames: Sequence[Any], count: int) -> ca.SX:
        """Opposite forces along the line between two feet; for more the kernel of the rows of x, z and pitch."""
        if len(points) == 2:
            line = (points[1] - points[0])[list(self.axes)]
            return ca.vertcat(line, -line)
        return kernel_of_grasp([self.wrench(frame) for frame in frames], points, count, PLANE.places)


POINT = PointContact()
"""What every foot is unless a pattern says otherwise."""

PLANAR_POINT = PlanarPointContact()
"""The same of a robot in the plane."""

CONTACTS: Registry[Contact] = Registry("contact")
"""The contacts that files can hold."""

CONTACTS.register("point", PointContact)
CONTACTS.register("planar point", PlanarPointContact)
