"""Making a nearly symmetric robot exactly symmetric, so that half a gait determines the other half.

All is averaged in the base frame at the zero pose, where a robot is a set of joint axes with bodies and feet on them:
where those mirror each other, so does the robot in every pose.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from amble.errors import InputError
from amble.robot.kinematics import link_pose
from amble.robot.mirror import REFLECTION, partners
from amble.robot.model import Robot
from amble.robot.parts import DRIVE, Foot, Joint, Link
from amble.types import Matrix, Vector, frozen

FARTHEST = 0.1
"""Largest distance of a joint or foot from its twin's mirror image, in leg lengths: more are no twins."""


@dataclass(frozen=True)
class _Frame:
    """Orientation and origin of a link in the base at the zero pose."""

    rotation: Matrix
    origin: Vector


def symmetrized(robot: Robot) -> Robot:
    """Return the robot with left and right averaged: inertias, joint axes, feet, rotors; limits as both allow.

    Real models differ by a part in a thousand from left to right. The result is symmetric to rounding.

    Raises:
        InputError: where feet have no twins, joints do not pair, or are too far from mirroring each other.
    """
    partner = partners(robot)
    twin = [0, *(partner[j] + 1 for j in range(len(robot.joints)))]
    old = [_Frame(*_at_zero(robot, link)) for link in range(len(robot.links))]
    signs = [_sign(robot, old, j, partner[j]) for j in range(len(robot.joints))]
    new = [old[0]]
    for j in range(len(robot.joints)):
        new.append(_averaged_frame(robot, old, j, partner[j], signs[j]))
    joints = tuple(
        _joint(robot, robot.joints[j], robot.joints[partner[j]], signs[j], new) for j in range(len(robot.joints))
    )
    links = tuple(_link(link, robot.links[twin[i]], old[i], old[twin[i]], new[i]) for i, link in enumerate(robot.links))
    other = {name: pair[1 - side] for pair in robot.twins for side, name in enumerate(pair)}
    feet = tuple(_foot(robot, foot, robot.foot(other[foot.name]), old, new) for foot in robot.feet)
    return replace(robot, links=links, joints=joints, feet=feet)


def _at_zero(robot: Robot, link: int) -> tuple[Matrix, Vector]:
    rotation, origin = link_pose(robot, link, np.zeros(robot.size))
    return np.asarray(rotation), np.asarray(origin).ravel()


def _axis(robot: Robot, frames: list[_Frame], j: int) -> Vector:
    return frames[j + 1].rotation @ robot.joints[j].axis


def _sign(robot: Robot, frames: list[_Frame], j: int, k: int) -> float:
    """Whether joint j moves as the mirror image of joint k does."""
    return 1.0 if _axis(robot, frames, j) @ _image(robot, frames, k) > 0.0 else -1.0


def _image(robot: Robot, frames: list[_Frame], k: int) -> Vector:
    """Mirror image of an axis: one of rotation is a pseudo-vector."""
    sense = 1.0 if robot.joints[k].prismatic else -1.0
    return np.asarray(sense * REFLECTION @ _axis(robot, frames, k))


def _averaged_frame(robot: Robot, old: list[_Frame], j: int, k: int, sign: float) -> _Frame:
    """Where the link of joint j has its origin and axis halfway to the mirror image of those of its twin."""
    image = REFLECTION @ old[k + 1].origin
    _require_near(robot, f"joint '{robot.joints[j].name}'", old[j + 1].origin - image)
    own = _axis(robot, old, j)
    mean = own + sign * _image(robot, old, k)
    turn = _smallest_turn(own, mean / np.linalg.norm(mean))
    return _Frame(turn @ old[j + 1].rotation, 0.5 * (old[j + 1].origin + image))


def _require_near(robot: Robot, what: str, apart: Vector) -> None:
    share = float(np.linalg.norm(apart)) / robot.leg_length
    if share > FARTHEST:
        raise InputError(
            f"robot '{robot.name}' cannot be symmetrized: {what} is {share:.2g} leg lengths from the mirror image of "
            "its twin; are the twins named right, and does the base have x forward and z up (base_rotation in [robot])?"
        )


def _smallest_turn(start: Vector, end: Vector) -> Matrix:
    """Return the rotation that takes one unit vector to another near it: I + [w] + [w]^2 / (1 + cos)."""
    x, y, z = np.cross(start, end)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.asarray(np.eye(3) + cross + cross @ cross / (1.0 + start @ end))


def _joint(robot: Robot, joint: Joint, twin: Joint, sign: float, new: list[_Frame]) -> Joint:
    parent, own = new[joint.parent], new[joint.child]
    other = (twin.lower, twin.upper) if sign > 0.0 else (-twin.upper, -twin.lower)
    lower, upper = max(joint.lower, other[0]), min(joint.upper, other[1])
    if lower > upper:
        raise InputError(
            f"robot '{robot.name}' cannot be symmetrized: joint '{joint.name}' moves from {joint.lower:g} to "
            f"{joint.upper:g} {joint.unit}, its twin '{twin.name}' mirrored from {other[0]:g} to {other[1]:g}"
        )
    return replace(
        joint,
        rotation=frozen(parent.rotation.T @ own.rotation),
        translation=frozen(parent.rotation.T @ (own.origin - parent.origin)),
        lower=lower,
        upper=upper,
        effort=min(joint.effort, twin.effort),
        velocity=min(joint.velocity, twin.velocity),
        **{what: 0.5 * (getattr(joint, what) + getattr(twin, what)) for what in DRIVE},
    )


def _link(link: Link, twin: Link, old: _Frame, old_twin: _Frame, new: _Frame) -> Link:
    centers = [frame.origin + frame.rotation @ body.center for body, frame in ((link, old), (twin, old_twin))]
    inertias = [frame.rotation @ body.inertia @ frame.rotation.T for body, frame in ((link, old), (twin, old_twin))]
    center = 0.5 * (centers[0] + REFLECTION @ centers[1])
    inertia = 0.5 * (inertias[0] + REFLECTION @ inertias[1] @ REFLECTION)
    return Link(
        link.name,
        0.5 * (link.mass + twin.mass),
        frozen(new.rotation.T @ (center - new.origin)),
        frozen(new.rotation.T @ inertia @ new.rotation),
    )


def _foot(robot: Robot, foot: Foot, twin: Foot, old: list[_Frame], new: list[_Frame]) -> Foot:
    own, image = (old[one.link].origin + old[one.link].rotation @ one.offset for one in (foot, twin))
    image = REFLECTION @ image
    _require_near(robot, f"foot '{foot.name}'", own - image)
    frame = new[foot.link]
    return replace(foot, offset=frozen(frame.rotation.T @ (0.5 * (own + image) - frame.origin)))
