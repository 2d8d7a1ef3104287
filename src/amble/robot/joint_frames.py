"""Joint frames slid along their own axes, which changes no motion but puts zeros into the arms between joints."""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

from amble.types import Vector, frozen

if TYPE_CHECKING:
    from amble.robot.model import Robot


def aligned_joint_frames(robot: Robot) -> Robot:
    """Return the same robot with every joint's origin at the point of its axis nearest to the parent joint's origin.

    Coordinates, dynamics and foot positions are those of ``robot``; positions of link frames are not.
    """
    joints = list(robot.joints)
    links = list(robot.links)
    feet = list(robot.feet)
    for j in robot.ordered_joints:
        joint = joints[j]
        step = -float((joint.rotation @ joint.axis) @ joint.translation) * joint.axis
        joints[j] = replace(joint, translation=frozen(joint.translation + joint.rotation @ step))
        links[joint.child] = replace(links[joint.child], center=_less(links[joint.child].center, step))
        for k, other in enumerate(joints):
            if other.parent == joint.child:
                joints[k] = replace(other, translation=_less(other.translation, step))
        for k, foot in enumerate(feet):
            if foot.link == joint.child:
                feet[k] = replace(foot, offset=_less(foot.offset, step))
    return replace(robot, joints=tuple(joints), links=tuple(links), feet=tuple(feet))


def _less(vector: Vector, step: Vector) -> Vector:
    return frozen(vector - step)
