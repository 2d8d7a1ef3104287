"""Motion of every link outwards, wrenches inwards: the recursion of Newton and Euler over links in their own frames.

Source: Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 5, with the base as a serial chain x, y, z, roll,
pitch, yaw: all in spatial coordinates (``Base.spatial``).

Inertial parameters of the links are regrouped so that the recursions need the fewest operations. Matter that is
symmetric about a revolute joint's axis moves the same whether it is fixed to the child or to the parent: point masses
on the axis, and so every combination of their parameters m, s m a and s^2 m (I - a a'). Each child hands its mass, its
first moment along the axis and one of its transverse moments of inertia to its parent (minimum inertial parameters;
Khalil and Dombre, Modeling, Identification and Control of Robots, 2002, section 9.4.2). A link on a prismatic joint
turns as its parent does, and hands its whole inertia about its origin. Forces, energy and
momentum of the whole robot stay the same; parameters of a single body lose their meaning.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from amble.robot.base import SPATIAL
from amble.robot.kinematics import X, Y, Z, angle_axes, base_rotation, joint_frame
from amble.robot.rotation import constant, cross, rotation_about, skew
from amble.types import Matrix, Vector

if TYPE_CHECKING:
    from amble.robot.model import Robot
    from amble.robot.parts import Joint

Wrench = tuple[ca.SX, ca.SX]
"""Force (or linear momentum) and moment about the link's origin (or angular momentum), link axes."""


@dataclass(frozen=True)
class Body:
    """Base inertial parameters of a link.

    Attributes:
        mass: kg.
        first_moment: first moment of mass about the link's origin, link axes, (3,), kg m.
        inertia: second moment about the link's origin, link axes, (3, 3), kg m^2.
    """

    mass: float
    first_moment: Vector
    inertia: Matrix


def base_inertial_parameters(robot: Robot) -> list[Body]:
    """Return one body a link, base first; links on revolute joints have mass zero."""
    bodies = []
    for link in robot.links:
        arm = skew(link.center)
        bodies.append(Body(link.mass, link.mass * link.center, link.inertia - link.mass * arm @ arm))
    for j in reversed(robot.ordered_joints):
        joint = robot.joints[j]
        own = bodies[joint.child]
        handed = Body(0.0, np.zeros(3), own.inertia) if joint.prismatic else _symmetric_part(own, joint.axis)
        bodies[joint.child] = _sum(bodies[joint.child], handed, -1.0)
        bodies[joint.parent] = _sum(bodies[joint.parent], _seen_from_parent(handed, joint), 1.0)
    return bodies


def _symmetric_part(body: Body, axis: Vector) -> Body:
    """What can be handed to the parent: symmetric about the axis, chosen to leave as many zeros as possible."""
    across = np.eye(3) - np.outer(axis, axis)
    transverse = int(np.flatnonzero(np.diag(across) == np.diag(across).max())[-1])
    share = body.inertia[transverse, transverse] / across[transverse, transverse]
    return Body(body.mass, axis * (axis @ body.first_moment), share * across)


def _seen_from_parent(body: Body, joint: Joint) -> Body:
    """Express a body that is symmetric about the joint's axis in the parent's frame (parallel axes)."""
    rotation, arm = joint.rotation, joint.translation
    first_moment = rotation @ body.first_moment
    shift = skew(arm) @ skew(first_moment)
    inertia = rotation @ body.inertia @ rotation.T - shift - shift.T - body.mass * skew(arm) @ skew(arm)
    return Body(body.mass, first_moment + body.mass * arm, inertia)


def _sum(body: Body, other: Body, factor: float) -> Body:
    return Body(
        body.mass + factor * other.mass,
        body.first_moment + factor * other.first_moment,
        body.inertia + factor * other.inertia,
    )


@dataclass(frozen=True)
class Motion:
    """Angular velocity and acceleration of a link, linear velocity and acceleration of its origin, link axes."""

    angular_velocity: ca.SX
    angular_acceleration: ca.SX
    velocity: ca.SX
    acceleration: ca.SX


@dataclass(frozen=True)
class Frames:
    """Orientation and origin of every joint's frame in its parent link."""

    rotations: list[ca.SX]
    translations: list[ca.SX | ca.DM]


def joint_frames(robot: Robot, q: ca.SX) -> Frames:
    """Return the joint frames at coordinates q."""
    found = [joint_frame(joint, q[SPATIAL + number]) for number, joint in enumerate(robot.joints)]
    return Frames([rotation for rotation, _ in found], [place for _, place in found])


def newton_euler(robot: Robot, q: ca.SX, v: ca.SX, a: ca.SX) -> ca.SX:
    """Return D a + h, (n_q,)."""
    frames = joint_frames(robot, q)
    motions = _motions(robot, frames, _base_motion(q, v, a, robot.gravity), v, a)
    wrenches = [
        _inertial_wrench(body, motion) for body, motion in zip(base_inertial_parameters(robot), motions, strict=True)
    ]
    total = _gather(robot, frames, wrenches)
    torques = [constant(joint.axis).T @ total[joint.child][0 if joint.prismatic else 1] for joint in robot.joints]
    force, moment = total[0]
    return ca.densify(ca.vertcat(base_rotation(q) @ force, angle_axes(q).T @ moment, *torques))


def energy_and_momentum(robot: Robot, q: ca.SX, v: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX]:
    """Return kinetic energy, linear momentum and angular momentum about the world origin, world axes."""
    frames, still = joint_frames(robot, q), ca.SX(q.shape[0], 1)
    motions = _motions(robot, frames, _base_motion(q, v, still, 0.0), v, still)
    parts = [_momentum(body, motion) for body, motion in zip(base_inertial_parameters(robot), motions, strict=True)]
    energy = sum(
        0.5 * (ca.dot(linear, motion.velocity) + ca.dot(angular, motion.angular_velocity))
        for (linear, angular), motion in zip(parts, motions, strict=True)
    )
    linear, angular = (base_rotation(q) @ part for part in _gather(robot, frames, parts)[0])
    return energy, ca.densify(linear), ca.densify(angular + cross(q[:3], linear))


def _base_motion(q: ca.SX, v: ca.SX, a: ca.SX, gravity: float) -> Motion:
    """Motion of the base in its own axes; gravity enters as an upward acceleration of the world."""
    rotation = base_rotation(q)
    velocity, acceleration = ca.SX(3, 1), ca.SX(3, 1)
    for index, axis in ((3, X), (4, Y), (5, Z)):
        step = rotation_about(axis, q[index]).T
        velocity, acceleration = step @ velocity, step @ acceleration
        acceleration += cross(velocity, constant(axis)) * v[index] + constant(axis) * a[index]
        velocity += constant(axis) * v[index]
    lift = ca.vertcat(a[0], a[1], a[2] + gravity)
    return Motion(velocity, acceleration, rotation.T @ v[:3], rotation.T @ lift)


def _motions(robot: Robot, frames: Frames, base: Motion, v: ca.SX, a: ca.SX) -> list[Motion]:
    """Propagate motion from the base outwards."""
    motions = [base] * len(robot.links)
    for j in robot.ordered_joints:
        joint, on = robot.joints[j], motions[robot.joints[j].parent]
        axis, step, arm = constant(joint.axis), frames.rotations[j].T, frames.translations[j]
        spin, turning = step @ on.angular_velocity, step @ on.angular_acceleration
        velocity = step @ (on.velocity + cross(on.angular_velocity, arm))
        acceleration = step @ (on.acceleration + _swirl(on) @ arm)
        bent = cross(spin, axis) * v[SPATIAL + j]
        if joint.prismatic:
            velocity = velocity + axis * v[SPATIAL + j]
            acceleration = acceleration + axis * a[SPATIAL + j] + 2 * bent
        else:
            turning = turning + axis * a[SPATIAL + j] + bent
            spin = spin + axis * v[SPATIAL + j]
        motions[joint.child] = Motion(spin, turning, velocity, acceleration)
    return motions


def _swirl(motion: Motion) -> ca.SX:
    """Return [w'] + [w][w] of the angular velocity w: from an arm to the acceleration of its tip beside its root."""
    x, y, z = ca.vertsplit(motion.angular_velocity)
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    a, b, c = ca.vertsplit(motion.angular_acceleration)
    return ca.vertcat(
        ca.horzcat(-(yy + zz), xy - c, xz + b),
        ca.horzcat(xy + c, -(xx + zz), yz - a),
        ca.horzcat(xz - b, yz + a, -(xx + yy)),
    )


def _inertial_wrench(body: Body, motion: Motion) -> Wrench:
    """Rate of momentum of a body (Newton, Euler), by which gravity is already an acceleration."""
    first_moment, inertia = constant(body.first_moment), constant(body.inertia)
    spin, acceleration = motion.angular_velocity, motion.angular_acceleration
    force = body.mass * motion.acceleration + _swirl(motion) @ first_moment
    moment = inertia @ acceleration + cross(spin, inertia @ spin) + cross(first_moment, motion.acceleration)
    return force, moment


def _momentum(body: Body, motion: Motion) -> Wrench:
    first_moment = constant(body.first_moment)
    linear = body.mass * motion.velocity + cross(motion.angular_velocity, first_moment)
    return linear, constant(body.inertia) @ motion.angular_velocity + cross(first_moment, motion.velocity)


def _gather(robot: Robot, frames: Frames, wrenches: list[Wrench]) -> list[Wrench]:
    """Sum every link's wrench with those of the links beyond it, inwards to the base."""
    total = list(wrenches)
    for j in reversed(robot.ordered_joints):
        joint, rotation, arm = robot.joints[j], frames.rotations[j], frames.translations[j]
        force, moment = total[joint.child]
        force_on, moment_on = total[joint.parent]
        carried = rotation @ force
        total[joint.parent] = (force_on + carried, moment_on + rotation @ moment + cross(arm, carried))
    return total
