"""Feet proposed for a robot whose file is all that is known; which foot is which is for people to confirm."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from amble.errors import InputError
from amble.robot.kinematics import link_pose
from amble.robot.loading import carried_frames, load_robot
from amble.robot.model import Robot
from amble.types import Vector

SHORTEST = 2
"""Joints of a chain that may be a leg."""

LABELS = {2: ("l", "r"), 4: ("fl", "fr", "rl", "rr"), 6: ("fl", "fr", "ml", "mr", "rl", "rr")}
"""Number of legs -> labels from front to back, left before right; twins follow each other."""


def proposed_feet(path: str | Path) -> dict[str, str]:
    """Return label -> frame: at the end of every chain of joints the frame furthest from the last joint.

    Labels go by where the chains leave the base: x forward, y to the left.

    Raises:
        InputError: the file cannot be used, or it has no two, four or six chains that could be legs.
    """
    path = Path(path)
    robot, frames = load_robot(path, {}), carried_frames(path)
    moved = {joint.parent for joint in robot.joints}
    ends = [link for link in range(1, len(robot.links)) if link not in moved and len(robot.chain(link)) >= SHORTEST]
    if len(ends) not in LABELS:
        raise InputError(
            f"{path.name}: {len(ends)} chains of joints could be legs, so no feet are proposed; name them: "
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


def proposed_twins(labels: tuple[str, ...]) -> list[tuple[str, str]]:
    """Return the pairs of labels that differ in a last letter l and r."""
    return [(label, f"{label[:-1]}r") for label in labels if label.endswith("l") and f"{label[:-1]}r" in labels]


def _hip(robot: Robot, link: int) -> Vector:
    """Where the first joint of a leg is at the zero pose, (3,), m."""
    first = robot.chain(link)[0]
    return np.asarray(link_pose(robot, robot.joints[first].child, np.zeros(robot.size))[1]).ravel()
