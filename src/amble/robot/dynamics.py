"""Dynamics D(q) a + h(q, v) = generalised forces, as casadi expressions.

Rotors, damping and dry friction of the joints (``drive``) are part of D and h, so that torques are those of the motors.

Coordinates and velocities are those of `kinematics`: v = dq/dt, not a body twist. Every function takes casadi SX, MX,
DM or numpy and returns the matching casadi type. Expressions built from several calls share sines and cosines only
after `casadi.cse`.

The mass matrix is that of composite rigid bodies (Featherstone, Rigid Body Dynamics Algorithms, 2008, chapter 6).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import casadi as ca

from amble.robot.base import SPATIAL
from amble.robot.drive import resistance, rotor_energy, rotor_inertia
from amble.robot.kinematics import aligned_joint_frames, angle_axes, base_rotation, link_poses
from amble.robot.newton_euler import Frames, base_inertial_parameters, energy_and_momentum, joint_frames, newton_euler
from amble.robot.rotation import constant, cross

if TYPE_CHECKING:
    from amble.robot.model import Robot

Composite = tuple[float, ca.SX, ca.SX]
"""Mass, first moment and inertia about the origin of a link with all that it carries, link axes."""

Entries = dict[tuple[int, int], ca.SX]
"""Row and column -> entry of a symmetric matrix, either of a pair."""


def mass_matrix(robot: Robot, q: Any) -> Any:
    """Return D, (n_q, n_q), symmetric; entries between different legs are structurally zero."""
    return _mass_matrix(robot)(q)


def bias(robot: Robot, q: Any, v: Any) -> Any:
    """Return h = Coriolis, centrifugal and gravity forces, damping and friction of the joints, (n_q,), N or N m."""
    return _bias(robot)(q, v)


def inverse_dynamics(robot: Robot, q: Any, v: Any, a: Any) -> Any:
    """Return D a + h, the generalised forces without contact, (n_q,), N or N m."""
    return _inverse_dynamics(robot)(q, v, a)


def kinetic_energy(robot: Robot, q: Any, v: Any) -> Any:
    """Return the kinetic energy, J."""
    return _energy_and_momentum(robot)(q, v)[0]


def potential_energy(robot: Robot, q: Any) -> Any:
    """Return the potential energy above z = 0, J."""
    return _potential_energy(robot)(q)


def momentum(robot: Robot, q: Any, v: Any) -> tuple[Any, Any]:
    """Return linear momentum, (3,), N s, and angular momentum about the world origin, (3,), N m s; world axes."""
    _, linear, angular = _energy_and_momentum(robot)(q, v)
    return linear, angular


def _function(name: str, robot: Robot, letters: str, build: Callable[..., Sequence[ca.SX]]) -> ca.Function:
    symbols = [ca.SX.sym(letter, robot.size) for letter in letters]
    return ca.Function(name, symbols, ca.cse(list(build(*symbols))))


@lru_cache(maxsize=64)
def _mass_matrix(robot: Robot) -> ca.Function:
    def build(q: ca.SX) -> list[ca.SX]:
        whole = composite_rigid_body(aligned_joint_frames(robot), robot.base.spatial(q))
        own = _own(robot)
        return [(whole if robot.base.in_space else ca.sparsify(whole[own, own])) + rotor_inertia(robot)]

    return _function("mass_matrix", robot, "q", build)


@lru_cache(maxsize=64)
def _bias(robot: Robot) -> ca.Function:
    still = ca.SX(robot.size, 1)
    return _function("bias", robot, "qv", lambda q, v: [_newton_euler(robot, q, v, still) + resistance(robot, v)])


@lru_cache(maxsize=64)
def _inverse_dynamics(robot: Robot) -> ca.Function:
    def build(q: ca.SX, v: ca.SX, a: ca.SX) -> list[ca.SX]:
        return [_newton_euler(robot, q, v, a) + rotor_inertia(robot) @ a + resistance(robot, v)]

    return _function("inverse_dynamics", robot, "qva", build)


@lru_cache(maxsize=64)
def _energy_and_momentum(robot: Robot) -> ca.Function:
    def build(q: ca.SX, v: ca.SX) -> tuple[ca.SX, ...]:
        energy, linear, angular = energy_and_momentum(aligned_joint_frames(robot), *map(robot.base.spatial, (q, v)))
        return energy + rotor_energy(robot, v), linear, angular

    return _function("energy_and_momentum", robot, "qv", build)


@lru_cache(maxsize=64)
def _potential_energy(robot: Robot) -> ca.Function:
    def build(own: ca.SX) -> list[ca.SX]:
        q = robot.base.spatial(own)
        first_moments = [
            link.mass * (origin + rotation @ constant(link.center))
            for link, (rotation, origin) in zip(robot.links, link_poses(robot, q), strict=True)
        ]
        rise = base_rotation(q)[2, :] @ sum(first_moments, ca.SX(3, 1))
        return [robot.gravity * (robot.mass * q[2] + rise)]

    return _function("potential_energy", robot, "q", build)


def _own(robot: Robot) -> list[int]:
    """Where the robot's coordinates stand among the spatial ones."""
    return robot.base.columns(len(robot.joints))


def _newton_euler(robot: Robot, q: ca.SX, v: ca.SX, a: ca.SX) -> ca.SX:
    """Rows of ``newton_euler`` of the robot's coordinates."""
    return newton_euler(aligned_joint_frames(robot), *map(robot.base.spatial, (q, v, a)))[_own(robot)]


def composite_rigid_body(robot: Robot, q: ca.SX) -> ca.SX:
    """Return D in spatial coordinates, with structural zeros between different legs."""
    frames = joint_frames(robot, q)
    bodies = _composites(robot, frames)
    entries: Entries = {}
    _enter_base(entries, q, bodies[0])
    for j in range(len(robot.joints)):
        _enter_joint(entries, robot, q, frames, j, bodies[robot.joints[j].child])
    return _symmetric_matrix(entries, q.shape[0])


def _symmetric_matrix(entries: Entries, size: int) -> ca.SX:
    """Return the matrix at once: an entry that is set in a sparse matrix costs as much as all before it."""
    whole = {(column, row): value for (row, column), value in entries.items()} | entries
    places = sorted(whole, key=lambda place: place[::-1])
    rows, columns = zip(*places, strict=True)
    values = ca.vertcat(*(whole[place] for place in places))
    return ca.sparsify(ca.SX(ca.Sparsity.triplet(size, size, rows, columns), values))


def _enter_base(entries: Entries, q: ca.SX, body: Composite) -> None:
    """Enter the block of the six base coordinates."""
    mass, first_moment, inertia = body
    axes = angle_axes(q)
    angular = inertia @ axes
    for i in range(3):
        entries[i, i] = ca.SX(mass)
        force = base_rotation(q) @ cross(axes[:, i], first_moment)
        for k in range(3):
            entries[k, 3 + i] = force[k]
        for k in range(i + 1):
            entries[3 + k, 3 + i] = ca.dot(axes[:, k], angular[:, i])


def _enter_joint(entries: Entries, robot: Robot, q: ca.SX, frames: Frames, j: int, body: Composite) -> None:
    """Enter the row of a joint: the wrench that accelerates it, seen by every joint below and by the base."""
    mass, first_moment, inertia = body
    axis = constant(robot.joints[j].axis)
    if robot.joints[j].prismatic:
        force, moment = mass * axis, cross(first_moment, axis)
    else:
        force, moment = cross(axis, first_moment), inertia @ axis
    for below in reversed(robot.chain(robot.joints[j].child)):
        along = force if robot.joints[below].prismatic else moment
        entries[SPATIAL + j, SPATIAL + below] = ca.dot(constant(robot.joints[below].axis), along)
        arm, rotation = frames.translations[below], frames.rotations[below]
        force = rotation @ force
        moment = rotation @ moment + cross(arm, force)
    force, moment = base_rotation(q) @ force, angle_axes(q).T @ moment
    for k in range(3):
        entries[SPATIAL + j, k] = force[k]
        entries[SPATIAL + j, 3 + k] = moment[k]


def _composites(robot: Robot, frames: Frames) -> list[Composite]:
    """Gather bodies inwards."""
    bodies = [
        (b.mass, ca.SX(constant(b.first_moment)), ca.SX(constant(b.inertia))) for b in base_inertial_parameters(robot)
    ]
    for j in reversed(robot.ordered_joints):
        joint, rotation, arm = robot.joints[j], frames.rotations[j], frames.translations[j]
        mass, first_moment, inertia = bodies[joint.child]
        mass_on, first_moment_on, inertia_on = bodies[joint.parent]
        rotated = rotation @ first_moment
        shifted = _rotated(rotation, inertia) + _parallel_axes(mass, rotated, arm)
        bodies[joint.parent] = (mass_on + mass, first_moment_on + rotated + mass * arm, inertia_on + shifted)
    return bodies


def _rotated(rotation: ca.SX, inertia: ca.SX) -> ca.SX:
    """Return R I R', of which only one triangle is computed."""
    half = rotation @ inertia
    return _symmetric({(i, j): ca.dot(half[i, :], rotation[j, :]) for i in range(3) for j in range(i, 3)})


def _parallel_axes(mass: float, first_moment: ca.SX, arm: ca.SX | ca.DM) -> ca.SX:
    """What an inertia about one origin gains about another: (2 p.c + m p.p) I - (p c' + c p' + m p p')."""
    mixed = first_moment + 0.5 * mass * arm
    diagonal = 2 * ca.dot(arm, mixed)
    upper = {}
    for i in range(3):
        for j in range(i, 3):
            product = arm[i] * mixed[j] + mixed[i] * arm[j]
            upper[i, j] = diagonal - product if i == j else -product
    return _symmetric(upper)


def _symmetric(upper: dict[tuple[int, int], ca.SX]) -> ca.SX:
    return ca.vertcat(*(ca.horzcat(*(upper[min(i, j), max(i, j)] for j in range(3))) for i in range(3)))
