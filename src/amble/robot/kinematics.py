"""Kinematics: positions, Jacobians and velocity-dependent accelerations of point feet, as casadi expressions.

Coordinates are q = (x, y, z, roll, pitch, yaw, joints), of a robot in the plane (x, z, pitch, joints); the base
orientation is R = Rx(roll) Ry(pitch) Rz(yaw). Every function takes casadi SX, MX, DM or numpy and returns the matching
casadi type; those without a robot, and ``link_poses``, take spatial coordinates (``Base.spatial``).
"""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from amble.robot.base import SPATIAL
from amble.robot.rotation import constant, cross, rotation_about
from amble.types import Matrix, Vector, frozen

if TYPE_CHECKING:
    from amble.robot.model import Robot
    from amble.robot.parts import Joint

X, Y, Z = np.eye(3)


def base_rotation(q: Any) -> Any:
    """Return the base orientation R = Rx(roll) Ry(pitch) Rz(yaw), base to world, (3, 3)."""
    return ca.mtimes([rotation_about(X, q[3]), rotation_about(Y, q[4]), rotation_about(Z, q[5])])


def angle_axes(q: Any) -> Any:
    """Return E with body angular velocity = E (d roll, d pitch, d yaw)/dt, in base axes, (3, 3)."""
    after_pitch = rotation_about(Z, q[5]).T
    after_roll = ca.mtimes(rotation_about(Y, q[4]), rotation_about(Z, q[5])).T
    return ca.horzcat(after_roll @ constant(X), after_pitch @ constant(Y), constant(Z))


def link_poses(robot: Robot, q: Any) -> list[tuple[Any, Any]]:
    """Return orientation (3, 3) and origin (3,) of every link in base axes, relative to the base frame."""
    poses: list[tuple[Any, Any]] = [(ca.SX.eye(3), ca.SX(3, 1))] * len(robot.links)
    for j in robot.ordered_joints:
        rotation, origin = poses[robot.joints[j].parent]
        frame, place = joint_frame(robot.joints[j], q[SPATIAL + j])
        poses[robot.joints[j].child] = (rotation @ frame, origin + rotation @ place)
    return poses


def joint_frame(joint: Joint, value: Any) -> tuple[Any, Any]:
    """Return orientation (3, 3) and origin (3,) of a joint's frame in its parent link, at an angle or displacement."""
    rotation, place = constant(joint.rotation), constant(joint.translation)
    if joint.prismatic:
        return rotation, place + constant(joint.rotation @ joint.axis) * value
    return rotation @ rotation_about(joint.axis, value), place


@lru_cache(maxsize=16)
def zero_poses(robot: Robot) -> tuple[tuple[Matrix, Vector], ...]:
    """Return orientation (3, 3) and origin (3,) of every link at the zero pose, as numbers, in one walk of the tree."""
    poses: list[tuple[Matrix, Vector]] = [(np.eye(3), np.zeros(3))] * len(robot.links)
    for joint in (robot.joints[j] for j in robot.ordered_joints):
        rotation, origin = poses[joint.parent]
        poses[joint.child] = (rotation @ joint.rotation, origin + rotation @ joint.translation)
    return tuple(poses)


def link_pose(robot: Robot, link: int, q: Any) -> tuple[Any, Any]:
    """Return orientation (3, 3) and origin (3,) of one link in the world."""
    rotation, origin = _link_pose(robot, link)(q)
    return rotation, origin


def foot_position(robot: Robot, foot: str, q: Any) -> Any:
    """Return the position of a foot in the world, (3,), m.

    Raises:
        UnknownNameError: the robot has no such foot.
    """
    return _foot_position(robot, robot.foot(foot).name)(q)


def foot_jacobian(robot: Robot, foot: str, q: Any) -> Any:
    """Return J = d position / d q of a foot, (3, n_q); columns of other legs are structurally zero.

    Raises:
        UnknownNameError: the robot has no such foot.
    """
    return _foot_jacobian(robot, robot.foot(foot).name)(q)


def foot_bias(robot: Robot, foot: str, q: Any, v: Any) -> Any:
    """Return (dJ/dt) v of a foot: its acceleration where the coordinates do not accelerate, (3,), m/s^2.

    Raises:
        UnknownNameError: the robot has no such foot.
    """
    return _foot_bias(robot, robot.foot(foot).name)(q, v)


def foot_rotation_jacobian(robot: Robot, foot: str, q: Any) -> Any:
    """Return the Jacobian of the angular velocity of the link that carries a foot, world axes, (3, n_q).

    Raises:
        UnknownNameError: the robot has no such foot.
    """
    return _foot_rotation_jacobian(robot, robot.foot(foot).name)(q)


@lru_cache(maxsize=256)
def _link_pose(robot: Robot, link: int) -> ca.Function:
    q, s = _symbols(robot, "q")
    rotation, origin = link_poses(robot, s)[link]
    base = base_rotation(s)
    return ca.Function("link_pose", [q], [ca.densify(base @ rotation), ca.densify(s[:3] + base @ origin)])


@lru_cache(maxsize=256)
def _foot_position(robot: Robot, foot: str) -> ca.Function:
    robot = aligned_joint_frames(robot)
    q, s = _symbols(robot, "q")
    return ca.Function("foot_position", [q], [ca.densify(s[:3] + base_rotation(s) @ _in_base(robot, foot, s))])


@lru_cache(maxsize=256)
def _foot_jacobian(robot: Robot, foot: str) -> ca.Function:
    robot = aligned_joint_frames(robot)
    q, s = _symbols(robot, "q")
    rotation, arm = base_rotation(s), _in_base(robot, foot, s)
    jacobian = ca.SX(3, s.shape[0])
    jacobian[:, :3] = ca.SX.eye(3)
    world_arm, about_roll = rotation @ arm, rotation_about(X, s[3])
    jacobian[:, 3] = cross(ca.SX(constant(X)), world_arm)
    jacobian[:, 4] = cross(about_roll @ constant(Y), world_arm)
    jacobian[:, 5] = cross(rotation @ constant(Z), world_arm)
    poses, record = link_poses(robot, s), robot.foot(foot)
    for j in robot.chain(record.link):
        link_rotation, origin = poses[j + 1]
        axis = link_rotation @ constant(robot.joints[j].axis)
        moved = axis if robot.joints[j].prismatic else cross(axis, arm - origin)
        jacobian[:, SPATIAL + j] = rotation @ moved
    return ca.Function("foot_jacobian", [q], [ca.sparsify(_own(robot, jacobian))])


@lru_cache(maxsize=256)
def _foot_rotation_jacobian(robot: Robot, foot: str) -> ca.Function:
    robot = aligned_joint_frames(robot)
    q, s = _symbols(robot, "q")
    rotation, about_roll = base_rotation(s), rotation_about(X, s[3])
    jacobian = ca.SX(3, s.shape[0])
    jacobian[:, 3] = constant(X)
    jacobian[:, 4] = about_roll @ constant(Y)
    jacobian[:, 5] = rotation @ constant(Z)
    poses = link_poses(robot, s)
    for j in robot.chain(robot.foot(foot).link):
        if not robot.joints[j].prismatic:
            jacobian[:, SPATIAL + j] = rotation @ (poses[j + 1][0] @ constant(robot.joints[j].axis))
    return ca.Function("foot_rotation_jacobian", [q], [ca.sparsify(_own(robot, jacobian))])


@lru_cache(maxsize=256)
def _foot_bias(robot: Robot, foot: str) -> ca.Function:
    robot = aligned_joint_frames(robot)
    (q, s), (v, rates) = _symbols(robot, "q"), _symbols(robot, "v")
    record, poses = robot.foot(foot), link_poses(robot, s)
    axes = angle_axes(s)
    angular_velocity = axes @ rates[3:6]
    # rates of the axes' directions: d(E)/dt (roll', pitch', yaw') by the chain of three joints
    turning = slice(4, 6) if robot.base.in_space else slice(None)  # the axes do not depend on the other coordinates
    angular_acceleration = ca.jtimes(axes @ rates[3:6], q[turning], v[turning])
    acceleration, parent = ca.SX(3, 1), ca.SX(3, 1)
    for j in robot.chain(record.link):
        rotation, origin = poses[j + 1]
        acceleration += _bias_of_arm(angular_velocity, angular_acceleration, origin - parent)
        axis = rotation @ constant(robot.joints[j].axis)
        parent = origin
        if robot.joints[j].prismatic:
            acceleration += 2 * cross(angular_velocity, axis) * rates[SPATIAL + j]
            continue
        angular_acceleration = angular_acceleration + cross(angular_velocity, axis) * rates[SPATIAL + j]
        angular_velocity = angular_velocity + axis * rates[SPATIAL + j]
    acceleration += _bias_of_arm(angular_velocity, angular_acceleration, _in_base(robot, foot, s) - parent)
    return ca.Function("foot_bias", [q, v], [ca.densify(base_rotation(s) @ acceleration)])


def _symbols(robot: Robot, letter: str) -> tuple[ca.SX, ca.SX]:
    """Coordinates of a robot as symbols, and the spatial ones."""
    own = ca.SX.sym(letter, robot.size)
    return own, robot.base.spatial(own)


def _own(robot: Robot, columns: ca.SX) -> ca.SX:
    """Of columns for the spatial coordinates those of the robot's."""
    return columns if robot.base.in_space else columns[:, robot.base.columns(len(robot.joints))]


def _bias_of_arm(angular_velocity: ca.SX, angular_acceleration: ca.SX, arm: ca.SX) -> ca.SX:
    """Acceleration of the tip of a rigid arm relative to its root."""
    return cross(angular_acceleration, arm) + cross(angular_velocity, cross(angular_velocity, arm))


def _in_base(robot: Robot, foot: str, q: ca.SX) -> ca.SX:
    record = robot.foot(foot)
    rotation, origin = link_poses(robot, q)[record.link]
    return origin + rotation @ constant(record.offset)


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
