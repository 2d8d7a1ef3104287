"""A posture to start from for a robot that nobody has described: feet under the hips, knees bent."""

from __future__ import annotations

import itertools

import numpy as np

from amble.errors import InputError
from amble.robot import catalogue
from amble.robot.catalogue import Posture
from amble.robot.kinematics import foot_position, link_pose
from amble.robot.model import Robot
from amble.types import Vector

LATERAL = 0.9
"""Share of a joint's axis along the base's y axis from which the joint counts as a pitch joint."""

BENT = 0.75
"""Height of the hip over the foot as a share of the leg below it, stretched."""

BENDS = ((0.7, -1.4), (-0.7, 1.4))
"""Where the search starts, rad: knee behind the hip's vertical, then before it; later pitch joints start straight."""

PULL = 1e-3
"""Weight that keeps what the foot's place leaves free near the start, beside a relative error of the place."""

ACCURACY = 0.02
"""Relative error of a foot's place up to which a posture counts as found; it is only where a solver starts."""


def nominal_posture(robot: Robot) -> Posture:
    """Return the posture of the catalogue for a robot of it, unchanged; else ``standing_posture``, errors as there."""
    return catalogue.posture(robot.name) if catalogue.holds(robot) else standing_posture(robot)


def standing_posture(robot: Robot) -> Posture:
    """Return a level posture in which every foot stands below its leg's first pitch joint, within the joint limits.

    Pitch joints are those whose axis is lateral in the zero pose; all others stay at zero, or at the limit nearest to
    it. All legs bend the same way where both ways are open to them.

    Raises:
        InputError: a leg has no two pitch joints, or none of its poses brings the foot there.
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
    if len(pitching) < 2:
        raise InputError(f"leg '{foot}' has no two pitch joints, so no posture is known for it; give one: posture=...")
    known = _coordinates(robot, angles)
    columns = [robot.coordinate_index(name) for name in pitching]
    lower, upper = (np.array([getattr(robot.joint(name), end) for name in pitching]) for end in ("lower", "upper"))
    hip = _origin(robot, pitching[0], known)
    chain = [_origin(robot, name, known) for name in pitching] + [_foot(robot, foot, known)]
    length = float(sum(np.linalg.norm(b - a) for a, b in itertools.pairwise(chain)))
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


def _is_lateral(robot: Robot, name: str) -> bool:
    record = robot.joint(name)
    rotation, _ = link_pose(robot, record.child, np.zeros(robot.size))
    return bool(abs((np.asarray(rotation) @ record.axis)[1]) > LATERAL)


def _origin(robot: Robot, name: str, q: Vector) -> Vector:
    return np.asarray(link_pose(robot, robot.joint(name).child, q)[1]).ravel()


def _foot(robot: Robot, foot: str, q: Vector) -> Vector:
    return np.asarray(foot_position(robot, foot, q)).ravel()


def _coordinates(robot: Robot, angles: dict[str, float]) -> Vector:
    return Posture(0.0, angles).coordinates(robot)
