"""What a link looks like where nothing is known but the tree: bones from joint to joint, a box for the base.

The record of a robot holds no meshes, and a dynamics needs none. A bone runs from the joint that moves a link to each
joint or foot that the link carries; that is where forces pass, whatever the housing looks like.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.robot import Robot
from amble.types import Vector, frozen

CAPSULE, BOX = "capsule", "box"

THICKNESS = 0.055
"""Radius of the thickest bone, as a share of the leg length."""

TAPER = 0.8
"""Radius of a link over that of the link that carries it."""

THINNEST = 0.4
"""Smallest radius, as a share of the largest."""


@dataclass(frozen=True, kw_only=True)
class Shape:
    """A solid that moves with a link.

    Attributes:
        kind: "capsule" between two points, or "box" between two opposite corners along the link's axes.
        link: index of the link.
        first: a point in the link's frame, (3,), m.
        second: the other one, (3,), m.
        radius: of the capsule, m; 0 of a box.
    """

    kind: str
    link: int
    first: Vector
    second: Vector
    radius: float


def link_shapes(robot: Robot) -> tuple[Shape, ...]:
    """Return the solids of all links of a robot, the base's box first."""
    carried = _carried(robot)
    thick = THICKNESS * robot.leg_length
    base = np.array([*carried[0], robot.links[0].center])
    shapes = [
        Shape(
            kind=BOX,
            link=0,
            first=frozen(base.min(axis=0) - thick),
            second=frozen(base.max(axis=0) + thick),
            radius=0.0,
        )
    ]
    depths = {0: 0}
    for j in robot.ordered_joints:
        link = robot.joints[j].child
        depths[link] = depths[robot.joints[j].parent] + 1
        radius = thick * max(TAPER ** (depths[link] - 1), THINNEST)
        # a link that carries nothing hangs on its joint like a rod with its centre of mass in the middle
        for tip in carried[link] or [2.0 * robot.links[link].center]:
            shapes.append(Shape(kind=CAPSULE, link=link, first=frozen(np.zeros(3)), second=frozen(tip), radius=radius))
    return tuple(shapes)


def _carried(robot: Robot) -> list[list[Vector]]:
    """Joints and feet on every link, in its frame, m."""
    points: list[list[Vector]] = [[] for _ in robot.links]
    for joint in robot.joints:
        points[joint.parent].append(joint.translation)
    for foot in robot.feet:
        points[foot.link].append(foot.offset)
    return points
