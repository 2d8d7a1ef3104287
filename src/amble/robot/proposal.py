"""What is proposed for a robot whose file is all that is known: its feet, and a posture to start from.

Feet stand under the hips, knees bent. Which foot is which is for people to confirm.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from amble.errors import InputError
from amble.robot import catalogue
from amble.robot.catalogue import Posture
from amble.robot.kinematics import foot_position, link_pose, zero_poses
from amble.robot.loading import carried_frames, robot_from
from amble.robot.model import Robot
from amble.robot.readers import read_robot
from amble.types import Vector

SHORTEST = 2
"""Joints of a chain that may be a leg."""

LABELS = {2: ("l", "r"), 4: ("fl", "fr", "rl", "rr"), 6: ("fl", "fr", "ml", "mr", "rl", "rr")}
"""Number of legs -> labels from front to back, left before right; twins follow each other."""

LATERAL = 0.9
"""Share of a joint's axis along the base's y axis from which the joint counts as a pitch joint."""

MOST_PITCHING = 12
"""Pitch joints of a leg up to which a posture is searched for; legs of animals and machines have two to five."""

BENT = 0.75
"""Height of the hip over the foot as a share of the leg below it, stretched."""

BENDS = ((0.7, -1.4), (-0.7, 1.4))
"""Where the search starts, rad: knee behind the hip's vertical, then before it; later pitch joints start straight."""

PULL = 1e-3
"""Weight that keeps what the foot's place leaves free near the start, beside a relative error of the place."""

ACCURACY = 0.02
"""Relative error of a foot's place up to which a posture counts as found; it is only where a solver starts."""


def proposed_feet(path: str | Path) -> dict[str, str]:
    """Return label -> frame: at the end of every chain of joints the frame furthest from the last joint.

    Labels go by where the chains leave the base: x forward, y to the left.

    Raises:
        InputError: the file cannot be used, or it has no two, four or six chains that could be legs.
    """
    path = Path(path)
    file = read_robot(path)
    return feet_by_position(robot_from(file, path, {}), carried_frames(file, path), path.name)


def feet_by_position(robot: Robot, frames: Mapping[str, tuple[int, Vector]], source: str) -> dict[str, str]:
    """Return what ``proposed_feet`` does for a robot that was read, with its ``carried_frames``; errors as there."""
    moved = {joint.parent for joint in robot.joints}
    ends = [link for link in range(1, len(robot.links)) if link not in moved and len(robot.chain(link)) >= SHORTEST]
    if len(ends) not in LABELS:
        raise InputError(
            f"{source}: {len(ends)} chains of joints could be legs, so no feet are proposed; name them: "
            "label=link for every foot"
        )
    ordered: list[int] = []
    by_place = sorted(ends, key=lambda link: -_hip(robot, link)[0])
    for pair in range(0, len(by_place), 2):
        ordered += sorted(by_place[pair : pair + 2], key=lambda link: -_hip(robot, link)[1])

    def tip(link: int) -> str:
        own = {name: float(np.linalg.norm(offset)) for name, (carrier, offset) in frames.items() if carrier == link}
        return max(own, key=own.__getitem__)

    return {label: tip(link) for label, link in zip(LABELS[len(ends)], ordered, strict=True)}


def _hip(robot: Robot, link: int) -> Vector:
    """Where the first joint of a leg is at the zero pose, (3,), m."""
    first = robot.chain(link)[0]
    return zero_poses(robot)[robot.joints[first].child][1]


def nominal_posture(robot: Robot) -> Posture:
    """Return the posture of the catalogue for a robot of it, unchanged; else ``standing_posture``, errors as there."""
    return catalogue.posture(robot.name) if catalogue.holds(robot) else standing_posture(robot)


def standing_posture(robot: Robot) -> Posture:
    """Return a level posture in which every foot stands below its leg's first pitch joint, within the joint limits.

    Pitch joints are those that turn about an axis which is lateral in the zero pose; all others stay at zero, or at the
    limit nearest to it. All legs bend the same way where both ways are open to them. A leg with one pitch joint and
    prismatic joints stands with these in the middle of their ranges.

    Raises:
        InputError: a leg has no two pitch joints, nor one and a prismatic joint, or a great many, no length, or none of
            its poses brings the foot there.
    """
    angles = {joint.name: float(np.clip(0.0, joint.lower, joint.upper)) for joint in robot.joints}
    heights = []
    for foot, leg in robot.legs.items():
        found, below = _leg(robot, foot, leg, angles)
        angles.update(found)
        heights.append(below)
    return Posture(max(heights), {name: angles[name] for name in robot.joint_names})


def _leg(robot: Robot, foot: str, leg: tuple[str, ...], angles: dict[str, float]) -> tuple[dict[str, float], float]:
    """Return the pitch angles of a leg, and how far its foot is below the base, m."""
    from scipy.optimize import least_squares

    pitching = [name for name in leg if _is_lateral(robot, name)]
    sliding = [name for name in leg if robot.joint(name).prismatic]
    if len(pitching) == 1 and sliding:
        return _telescopic(robot, foot, pitching[0], {**angles, **{name: _middle(robot, name) for name in sliding}})
    if len(pitching) < 2:
        raise InputError(f"leg '{foot}' has no two pitch joints, so no posture is known for it; give one: posture=...")
    if len(pitching) > MOST_PITCHING:
        raise InputError(
            f"leg '{foot}' has {len(pitching)} pitch joints, more than {MOST_PITCHING}, so no posture is known for it; "
            "give one: posture=..."
        )
    known = _coordinates(robot, angles)
    columns = [robot.coordinate_index(name) for name in pitching]
    lower, upper = (np.array([getattr(robot.joint(name), end) for name in pitching]) for end in ("lower", "upper"))
    hip = _origin(robot, pitching[0], known)
    chain = [_origin(robot, name, known) for name in pitching] + [_foot(robot, foot, known)]
    length = float(sum(np.linalg.norm(b - a) for a, b in itertools.pairwise(chain)))
    if not length > 0.0:
        raise InputError(f"the pitch joints of leg '{foot}' and its foot are one point: the leg has no length")
    wanted = hip[[0, 2]] - np.array([0.0, BENT * length])

    def place(trial: Vector) -> Vector:
        q = known.copy()
        q[columns] = trial
        return _foot(robot, foot, q)

    for bend in BENDS:
        start = np.clip([*bend, *[0.0] * (len(pitching) - 2)], lower, upper)

        def residual(trial: Vector, start: Vector = start) -> Vector:
            return np.concatenate([(place(trial)[[0, 2]] - wanted) / length, PULL * (trial - start)])

        open_ends = (np.minimum(lower, start - 1e-6), np.maximum(upper, start + 1e-6))  # scipy wants the start inside
        found = np.clip(least_squares(residual, start, bounds=open_ends).x, lower, upper)
        there = place(found)
        if np.linalg.norm(there[[0, 2]] - wanted) < ACCURACY * length:
            return dict(zip(pitching, map(float, found), strict=True)), -float(there[2])
    raise InputError(f"no pose of leg '{foot}' brings the foot below the hip; give a posture: posture=...")


def _middle(robot: Robot, name: str) -> float:
    joint = robot.joint(name)
    finite = np.isfinite(joint.lower) and np.isfinite(joint.upper)
    return 0.5 * (joint.lower + joint.upper) if finite else float(np.clip(0.0, joint.lower, joint.upper))


def _telescopic(robot: Robot, foot: str, pitching: str, angles: dict[str, float]) -> tuple[dict[str, float], float]:
    """Turn the only pitch joint of a leg until the foot is below it; displacements are given."""
    known = _coordinates(robot, {**angles, pitching: 0.0})
    hip, joint = _origin(robot, pitching, known), robot.joint(pitching)
    ahead, _, up = _foot(robot, foot, known) - hip
    rotation, _ = zero_poses(robot)[joint.child]
    about = float(np.sign((rotation @ joint.axis)[1]))
    angle = about * float(np.arctan2(ahead, -up))  # a turn about y takes what is ahead down
    if not (np.hypot(ahead, up) > 0.0 and joint.lower <= angle <= joint.upper):
        raise InputError(f"no pose of leg '{foot}' brings the foot below the hip; give a posture: posture=...")
    found = {name: angles[name] for name in robot.legs[foot]} | {pitching: angle}
    return found, -float(_foot(robot, foot, _coordinates(robot, {**angles, **found}))[2])


def bent_ranges(robot: Robot, angles: Mapping[str, float], off_straight: float) -> dict[str, tuple[float, float]]:
    """Return pitch joint -> range in which the leg is bent at it as at a posture, at least so far off straight, rad.

    A leg is straight at a joint where the pitch joints before and after it, or the foot, are furthest apart. Joints
    that are nearer to that at the posture, and the first pitch joint of a leg, are not named.

    Args:
        robot: the robot.
        angles: joint angles of the posture.
        off_straight: least angle from straight, rad, below a quarter turn.
    """
    known, found = _coordinates(robot, dict(angles)), {}
    for foot, leg in robot.legs.items():
        pitching = [name for name in leg if _is_lateral(robot, name)]
        ends = [_origin(robot, name, known) for name in pitching] + [_foot(robot, foot, known)]
        for name, before, at, after in zip(pitching[1:], ends, ends[1:], ends[2:], strict=False):
            (x1, z1), (x2, z2) = (at - before)[[0, 2]], (after - at)[[0, 2]]
            bend = float(np.arctan2(x1 * z2 - z1 * x2, x1 * x2 + z1 * z2))  # about -y, from straight
            rotation, _ = link_pose(robot, robot.joint(name).child, known)
            turned = -float((np.asarray(rotation) @ robot.joint(name).axis)[1]) * bend
            straight, side = angles[name] - turned, np.sign(turned)
            if abs(bend) > off_straight:
                lower, upper = robot.joint(name).lower, robot.joint(name).upper
                edge = float(straight + side * off_straight)
                lower, upper = (max(lower, edge), upper) if side > 0.0 else (lower, min(upper, edge))
                if lower < upper:  # a posture outside its limits may leave nothing
                    found[name] = (lower, upper)
    return found


def _is_lateral(robot: Robot, name: str) -> bool:
    record = robot.joint(name)
    rotation, _ = zero_poses(robot)[record.child]
    return not record.prismatic and bool(abs((rotation @ record.axis)[1]) > LATERAL)


def _origin(robot: Robot, name: str, q: Vector) -> Vector:
    return np.asarray(link_pose(robot, robot.joint(name).child, q)[1]).ravel()


def _foot(robot: Robot, foot: str, q: Vector) -> Vector:
    return np.asarray(foot_position(robot, foot, q)).ravel()


def _coordinates(robot: Robot, angles: dict[str, float]) -> Vector:
    return Posture(0.0, angles).coordinates(robot)
