"""The base of a robot: in space, or in the plane of x and z; one object for what that changes.

A robot in the plane is one in space whose base keeps y, roll and yaw at zero: where all joints turn about y, nothing
moves it out of the plane. Kinematics and dynamics are written in the spatial coordinates, the base's six and the
joints, of which the robot's own coordinates are a part.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.robot.parts import BASE_COORDINATES

if TYPE_CHECKING:
    from amble.robot.model import Robot

SPATIAL = len(BASE_COORDINATES)

LATERAL = 1.0 - 1e-9
"""Least share of a joint's axis along y in a robot of a plane; files hold pi / 2 to ten digits."""

OUT_OF_PLANE = 1e-9
"""Largest share along y of the axis of a prismatic joint there."""


@dataclass(frozen=True)
class Base:
    """Which of the base's six coordinates move; the others stay zero.

    Attributes:
        name: as files have it.
        coordinates: those that move, in order.
    """

    name: str
    coordinates: tuple[str, ...]

    @property
    def size(self) -> int:
        """Number of coordinates."""
        return len(self.coordinates)

    @cached_property
    def places(self) -> tuple[int, ...]:
        """Where they stand among the six."""
        return tuple(map(BASE_COORDINATES.index, self.coordinates))

    @cached_property
    def axes(self) -> tuple[int, ...]:
        """Axes of the world along which the base moves: 0, 1, 2 for x, y, z."""
        return tuple(place for place in self.places if place < 3)

    @property
    def horizontal(self) -> int:
        """Coordinates of the horizontal position, the first ones."""
        return len(self.axes) - 1

    @property
    def in_space(self) -> bool:
        """Whether all six move."""
        return self.size == SPATIAL

    def columns(self, joints: int) -> list[int]:
        """Return where the robot's coordinates stand among the spatial ones."""
        return [*self.places, *range(SPATIAL, SPATIAL + joints)]

    def spatial(self, values: Any) -> Any:
        """Return spatial coordinates, or rates, of a robot's: casadi (n_q, m), or numpy with coordinates last."""
        if self.in_space:
            return values
        if isinstance(values, (ca.SX, ca.MX, ca.DM)):
            still = type(values)(1, values.shape[1])
            six = [still] * SPATIAL
            for row, place in enumerate(self.places):
                six[place] = values[row, :]
            return ca.vertcat(*six, values[self.size :, :])
        array = np.asarray(values)
        whole = np.zeros((*array.shape[:-1], array.shape[-1] - self.size + SPATIAL))
        whole[..., self.columns(array.shape[-1] - self.size)] = array
        return whole


SPACE = Base("space", BASE_COORDINATES)
PLANE = Base("plane", ("x", "z", "pitch"))

BASES = {base.name: base for base in (SPACE, PLANE)}
"""The bases by name."""


def check_plane(robot: Robot) -> None:
    """Refuse a robot in the plane with a joint that would leave it.

    Raises:
        InputError: a joint does not turn about the base's y axis, or slides along it.
    """
    rotations = [np.eye(3)] * len(robot.links)
    for joint in (robot.joints[j] for j in robot.ordered_joints):
        rotations[joint.child] = rotations[joint.parent] @ joint.rotation
        axis = rotations[joint.child] @ joint.axis
        inside = abs(axis[1]) < OUT_OF_PLANE if joint.prismatic else abs(axis[1]) > LATERAL
        if not inside:
            x, y, z = axis
            moves, wanted = ("slides along", "across y") if joint.prismatic else ("turns about", "about y")
            raise InputError(
                f"robot '{robot.name}' moves in the plane of x and z, but joint '{joint.name}' {moves} "
                f"({x:.3g}, {y:.3g}, {z:.3g}), not {wanted}: let it move in space, or lock the joint"
            )
