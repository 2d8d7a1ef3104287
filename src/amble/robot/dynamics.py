"""Dynamics D(q) a + h(q, v) = generalised forces, by recursions over links in their own frames.

The mass matrix comes from composite rigid bodies, everything else from Newton and Euler (Featherstone, Rigid Body
Dynamics Algorithms, 2008, chapters 5 and 6), with the base as a serial chain x, y, z, roll, pitch, yaw. Every function
takes casadi SX, MX, DM or numpy and returns the matching casadi type. Expressions built from several calls share
sines and cosines only after `casadi.cse`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca

from amble.robot.kinematics import X, Y, Z, angle_axes, base_rotation, link_poses
from amble.robot.model import Link, Robot
from amble.robot.rotation import constant, cross, rotation_about, skew


def mass_matrix(robot: Robot, q: Any) -> Any:
    """Return D, (n_q, n_q), symmetric; entries between different legs are structurally zero."""
    return _mass_matrix(robot)(q)


def bias(robot: Robot, q: Any, v: Any) -> Any:
    """Return h = Coriolis, centrifugal and gravity forces, (n_q,), N or N m."""
    return _bias(robot)(q, v)


def inverse_dynamics(robot: Robot, q: Any, v: Any, a: Any) -> Any:
    """Return D a + h, the generalised forces without contact, (n_q,), N or N m."""
    return _inverse_dynamics(robot)(q, v, a)


def kinetic_energy(robot: Robot, q: Any, v: Any) -> Any:
    """Return the kinetic energy, summed link by link, J."""
    return _energy_momentum(robot)(q, v)[0]


def potential_energy(robot: Robot, q: Any) -> Any:
    """Return the potential energy above z = 0, J."""
    return _potential_energy(robot)(q)


def momentum(robot: Robot, q: Any, v: Any) -> tuple[Any, Any]:
    """Return linear momentum, (3,), N s, and angular momentum about the world origin, (3,), N m s; world axes."""
    _, linear, angular = _energy_momentum(robot)(q, v)
    return linear, angular


@dataclass(frozen=True)
class _Motion:
    """Angular velocity and acceleration of a link and linear velocity and acceleration of its origin, link axes."""

    spin: ca.SX
    turn: ca.SX
    velocity: ca.SX
    acceleration: ca.SX


@dataclass(frozen=True)
class _Frames:
    """Orientation and origin of every joint's frame in its parent link."""

    rotations: list[ca.SX]
    translations: list[ca.DM]


def _frames(robot: Robot, q: ca.SX) -> _Frames:
    return _Frames(
        [constant(j.rotation) @ rotation_about(j.axis, q[6 + i]) for i, j in enumerate(robot.joints)],
        [constant(j.translation) for j in robot.joints],
    )


def _base_motion(q: ca.SX, v: ca.SX, a: ca.SX, gravity: float) -> _Motion:
    """Motion of the base in its own axes; gravity enters as an upward acceleration of the world."""
    rotation = base_rotation(q)
    spin, turn = ca.SX(3, 1), ca.SX(3, 1)
    for index, axis in ((3, X), (4, Y), (5, Z)):
        step = rotation_about(axis, q[index]).T
        spin, turn = step @ spin, step @ turn
        turn = turn + cross(spin, constant(axis)) * v[index] + constant(axis) * a[index]
        spin = spin + constant(axis) * v[index]
    lift = ca.vertcat(a[0], a[1], a[2] + gravity)
    return _Motion(spin, turn, rotation.T @ v[:3], rotation.T @ lift)


def _motions(robot: Robot, frames: _Frames, base: _Motion, v: ca.SX, a: ca.SX) -> list[_Motion]:
    """Propagate motion from the base outwards."""
    motions = [base] * len(robot.links)
    for j in robot.ordered_joints:
        joint, on = robot.joints[j], motions[robot.joints[j].parent]
        axis, step, arm = constant(joint.axis), frames.rotations[j].T, frames.translations[j]
        carried = step @ on.spin
        motions[joint.child] = _Motion(
            carried + axis * v[6 + j],
            step @ on.turn + axis * a[6 + j] + cross(carried, axis) * v[6 + j],
            step @ (on.velocity + cross(on.spin, arm)),
            step @ (on.acceleration + _swirl(on) @ arm),
        )
    return motions


def _swirl(motion: _Motion) -> ca.SX:
    """Return [turn]x + [spin]x [spin]x, which maps an arm to the relative acceleration of its tip."""
    x, y, z = ca.vertsplit(motion.spin)
    xx, yy, zz, xy, xz, yz = x * x, y * y, z * z, x * y, x * z, y * z
    a, b, c = ca.vertsplit(motion.turn)
    return ca.vertcat(
        ca.horzcat(-(yy + zz), xy - c, xz + b),
        ca.horzcat(xy + c, -(xx + zz), yz - a),
        ca.horzcat(xz - b, yz + a, -(xx + yy)),
    )


def _inertia_at_origin(link: Link) -> ca.DM:
    arm = skew(link.center)
    return constant(link.inertia - link.mass * arm @ arm)


def _inertial_wrench(link: Link, motion: _Motion) -> tuple[ca.SX, ca.SX]:
    """Return rate of momentum of a link: force and moment about its origin, link axes (Newton, Euler)."""
    moment = constant(link.mass * link.center)
    inertia = _inertia_at_origin(link)
    force = link.mass * motion.acceleration + _swirl(motion) @ moment
    torque = inertia @ motion.turn + cross(motion.spin, inertia @ motion.spin) + cross(moment, motion.acceleration)
    return force, torque


def _momentum_of(link: Link, motion: _Motion) -> tuple[ca.SX, ca.SX]:
    """Return linear and angular momentum of a link about its origin, link axes."""
    moment = constant(link.mass * link.center)
    linear = link.mass * motion.velocity + cross(motion.spin, moment)
    return linear, _inertia_at_origin(link) @ motion.spin + cross(moment, motion.velocity)


def _gather(robot: Robot, frames: _Frames, wrenches: list[tuple[ca.SX, ca.SX]]) -> list[tuple[ca.SX, ca.SX]]:
    """Sum every link's wrench with those of the links beyond it, inwards to the base."""
    total = list(wrenches)
    for j in reversed(robot.ordered_joints):
        joint = robot.joints[j]
        force, torque = total[joint.child]
        carried = frames.rotations[j] @ force
        force_on, torque_on = total[joint.parent]
        arm = frames.translations[j]
        total[joint.parent] = (force_on + carried, torque_on + frames.rotations[j] @ torque + cross(arm, carried))
    return total


def _newton_euler(robot: Robot, q: ca.SX, v: ca.SX, a: ca.SX) -> ca.SX:
    frames = _frames(robot, q)
    motions = _motions(robot, frames, _base_motion(q, v, a, robot.gravity), v, a)
    wrenches = [_inertial_wrench(link, motion) for link, motion in zip(robot.links, motions, strict=True)]
    total = _gather(robot, frames, wrenches)
    torques = [constant(joint.axis).T @ total[joint.child][1] for joint in robot.joints]
    force, torque = total[0]
    return ca.densify(ca.vertcat(base_rotation(q) @ force, angle_axes(q).T @ torque, *torques))


def _composites(robot: Robot, frames: _Frames) -> list[tuple[float, ca.SX, ca.SX]]:
    """Return mass, first moment and inertia about the origin of every link with all that it carries, link axes."""
    bodies = [
        (link.mass, ca.SX(constant(link.mass * link.center)), ca.SX(_inertia_at_origin(link))) for link in robot.links
    ]
    for j in reversed(robot.ordered_joints):
        joint, turn, arm = robot.joints[j], frames.rotations[j], frames.translations[j]
        mass, moment, inertia = bodies[joint.child]
        mass_on, moment_on, inertia_on = bodies[joint.parent]
        turned = turn @ moment
        shifted = _rotated(turn, inertia) + _parallel_axes(mass, turned, arm)
        bodies[joint.parent] = (mass_on + mass, moment_on + turned + mass * arm, inertia_on + shifted)
    return bodies


def _rotated(turn: ca.SX, inertia: ca.SX) -> ca.SX:
    """Return R I R', only one triangle of which is computed."""
    half = turn @ inertia
    upper = {(i, j): ca.dot(half[i, :], turn[j, :]) for i in range(3) for j in range(i, 3)}
    return _symmetric(upper)


def _parallel_axes(mass: float, moment: ca.SX, arm: ca.DM) -> ca.SX:
    """Return what an inertia about the old origin gains about the new one: -[p][c] - [c][p] - m [p][p]."""
    upper = {}
    # trace form: (2 p.c + m p.p) I - (p c' + c p' + m p p')
    mixed = moment + 0.5 * mass * arm
    diagonal = 2 * ca.dot(arm, mixed)
    for i in range(3):
        for j in range(i, 3):
            product = arm[i] * mixed[j] + mixed[i] * arm[j]
            upper[i, j] = diagonal - product if i == j else -product
    return _symmetric(upper)


def _symmetric(upper: dict[tuple[int, int], ca.SX]) -> ca.SX:
    return ca.vertcat(*(ca.horzcat(*(upper[min(i, j), max(i, j)] for j in range(3))) for i in range(3)))


def _composite_rigid_body(robot: Robot, q: ca.SX) -> ca.SX:
    frames, rotation, axes = _frames(robot, q), base_rotation(q), angle_axes(q)
    bodies = _composites(robot, frames)
    matrix = ca.SX(robot.size, robot.size)

    def enter(row: int, column: int, value: ca.SX) -> None:
        matrix[row, column] = value
        matrix[column, row] = value

    mass, moment, inertia = bodies[0]
    angular = inertia @ axes
    for i in range(3):
        matrix[i, i] = mass
        force = rotation @ cross(axes[:, i], moment)
        for k in range(3):
            enter(k, 3 + i, force[k])
        for k in range(i + 1):
            enter(3 + k, 3 + i, ca.dot(axes[:, k], angular[:, i]))
    for j, joint in enumerate(robot.joints):
        _, moment, inertia = bodies[joint.child]
        axis = constant(joint.axis)
        force, torque = cross(axis, moment), inertia @ axis
        enter(6 + j, 6 + j, ca.dot(axis, torque))
        below = j
        while True:
            arm, turn = frames.translations[below], frames.rotations[below]
            force = turn @ force
            torque = turn @ torque + cross(arm, force)
            link = robot.joints[below].parent
            if link == 0:
                break
            below = link - 1
            enter(6 + j, 6 + below, ca.dot(constant(robot.joints[below].axis), torque))
        force, torque = rotation @ force, axes.T @ torque
        for k in range(3):
            enter(6 + j, k, force[k])
            enter(6 + j, 3 + k, torque[k])
    return ca.sparsify(matrix)


def _symbols(robot: Robot, count: int) -> list[ca.SX]:
    return [ca.SX.sym(name, robot.size) for name in ("q", "v", "a")[:count]]


def _function(name: str, robot: Robot, build: Callable[..., list[ca.SX]], count: int) -> ca.Function:
    symbols = _symbols(robot, count)
    return ca.Function(name, symbols, ca.cse(build(*symbols)))


@lru_cache(maxsize=64)
def _mass_matrix(robot: Robot) -> ca.Function:
    return _function("mass_matrix", robot, lambda q: [_composite_rigid_body(robot, q)], 1)


@lru_cache(maxsize=64)
def _bias(robot: Robot) -> ca.Function:
    still = ca.SX(robot.size, 1)
    return _function("bias", robot, lambda q, v: [_newton_euler(robot, q, v, still)], 2)


@lru_cache(maxsize=64)
def _inverse_dynamics(robot: Robot) -> ca.Function:
    return _function("inverse_dynamics", robot, lambda q, v, a: [_newton_euler(robot, q, v, a)], 3)


@lru_cache(maxsize=64)
def _potential_energy(robot: Robot) -> ca.Function:
    def build(q: ca.SX) -> list[ca.SX]:
        heights = [
            link.mass * (origin + rotation @ constant(link.center))
            for link, (rotation, origin) in zip(robot.links, link_poses(robot, q), strict=True)
        ]
        moment = base_rotation(q)[2, :] @ sum(heights, ca.SX(3, 1))
        return [robot.gravity * (robot.mass * q[2] + moment)]

    return _function("potential_energy", robot, build, 1)


@lru_cache(maxsize=64)
def _energy_momentum(robot: Robot) -> ca.Function:
    def build(q: ca.SX, v: ca.SX) -> list[ca.SX]:
        frames, still = _frames(robot, q), ca.SX(robot.size, 1)
        motions = _motions(robot, frames, _base_motion(q, v, still, 0.0), v, still)
        parts = [_momentum_of(link, motion) for link, motion in zip(robot.links, motions, strict=True)]
        energy = sum(
            0.5 * (ca.dot(linear, motion.velocity) + ca.dot(angular, motion.spin))
            for (linear, angular), motion in zip(parts, motions, strict=True)
        )
        linear, angular = (base_rotation(q) @ part for part in _gather(robot, frames, parts)[0])
        return [energy, ca.densify(linear), ca.densify(angular + cross(q[:3], linear))]

    return _function("energy_momentum", robot, build, 2)
