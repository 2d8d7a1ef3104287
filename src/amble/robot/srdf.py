"""Postures that the SRDF file beside a URDF names: its group states, such as "standing"."""

from __future__ import annotations

import logging
import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from amble.errors import InputError, printable, shown, shown_path
from amble.robot.catalogue import Posture
from amble.robot.kinematics import foot_position
from amble.robot.model import Robot
from amble.robot.urdf import attribute, number, parsed_urdf

logger = logging.getLogger("amble")

FIRST = "standing"
"""The group state that is tried before others."""

LEVEL = 0.05
"""Largest difference of the feet's heights in a posture, in leg lengths; it is only where a solver starts."""

BEYOND = 1e-3
"""How far an angle may be beyond its limit, rad: files round."""

MOST_FILES = 20
"""Files of other names that are looked at for one of the robot's name."""

LARGEST, MOST_STATES = 2 * 2**20, 100
"""Bytes of an SRDF file, and its group states; those of real robots have up to 0.2 MB and 10."""


@dataclass(frozen=True)
class SrdfPosture:
    """A posture with the group state and the file that it is from."""

    posture: Posture
    state: str
    file: Path


def srdf_posture(robot: Robot, path: str | Path) -> SrdfPosture | None:
    """Return the first posture of the SRDF beside a robot's file in which the robot stands; says why others do not.

    Looked for is a file of the same name with the suffix .srdf in the folder, in its folder srdf and in the folder srdf
    beside it; then one there whose robot has the same name. In a state every joint of the robot has an angle within
    its limits, and the feet come to one height, which is that of the base above them.

    Args:
        robot: the robot, of that file.
        path: its file.

    Returns:
        None where there is no such file, or no state of it is a posture.
    """
    path = Path(path)
    for file in _beside(path):
        try:
            name, states = read_srdf(file)
        except InputError as error:
            logger.warning("%s", printable(str(error)))
            continue
        if file.stem != path.stem and name != robot.name:
            continue
        found = _standing(robot, file, states)
        if found is not None:
            return found
    return None


def read_srdf(path: Path) -> tuple[str, dict[str, dict[str, float]]]:
    """Read the group states of an SRDF file.

    Returns:
        The robot's name, and group state -> joint -> angle, rad (or place, m), of joints with one value.

    Raises:
        InputError: where the file is missing, is not an SRDF, or an element is incomplete or not a number.
    """
    root = parsed_urdf(path, "SRDF file", "SRDF", LARGEST)
    states: dict[str, dict[str, float]] = {}
    elements = root.findall("group_state")
    if len(elements) > MOST_STATES:
        raise InputError(f"SRDF file '{shown_path(path)}' has more than {MOST_STATES} group states")
    for element in elements:
        label = attribute(element, "name", f"{path.name}: a group state")
        where = f"{path.name}: group state '{shown(label)}'"
        values = states.setdefault(label, {})
        for joint in element.findall("joint"):
            name = attribute(joint, "name", where)
            words = attribute(joint, "value", where).split()
            if len(words) == 1:  # others are the base's place or balls and quaternions
                values[name] = number(words[0], f"{where}, joint '{shown(name)}'")
    return root.get("name") or path.stem, states


def _beside(path: Path) -> list[Path]:
    """Files that may belong to a robot's file, likeliest first."""
    folders = [path.parent, path.parent / "srdf", path.parent.parent / "srdf"]
    same = [folder / f"{path.stem}.srdf" for folder in folders]
    others = [file for folder in folders for file in _files(folder) if file not in same]
    return [file for file in dict.fromkeys((*same, *others[:MOST_FILES])) if os.path.isfile(file)]


def _files(folder: Path) -> list[Path]:
    try:
        return [folder / name for name in sorted(os.listdir(folder)) if name.endswith(".srdf")]
    except OSError:
        return []


def _standing(robot: Robot, file: Path, states: Mapping[str, Mapping[str, float]]) -> SrdfPosture | None:
    for state in sorted(states, key=lambda label: label != FIRST):
        angles = {joint: states[state][joint] for joint in robot.joint_names if joint in states[state]}
        reason, height = _why_not(robot, angles)
        if not reason:
            return SrdfPosture(Posture(height, angles), state, file)
        text = f"group state '{shown(state)}' of {shown(file.name)} is no posture to start from: {reason}"
        logger.warning("%s", printable(text))
    return None


def _why_not(robot: Robot, angles: Mapping[str, float]) -> tuple[str, float]:
    """Return why a robot does not stand with some angles, empty where it does, and the height of its base, m."""
    for joint in robot.joints:
        if joint.name not in angles:
            return f"it has no angle of joint '{joint.name}'", 0.0
        if not joint.lower - BEYOND <= angles[joint.name] <= joint.upper + BEYOND:
            return f"{angles[joint.name]:g} is beyond the limits of joint '{joint.name}'", 0.0
    q = Posture(0.0, angles).coordinates(robot)
    below = [-float(np.asarray(foot_position(robot, foot, q)).ravel()[2]) for foot in robot.foot_names]
    if not min(below) > 0.0:
        return "a foot is not below the base", 0.0
    if max(below) - min(below) > LEVEL * robot.leg_length:
        return f"its feet are {min(below):.3g} to {max(below):.3g} m below a level base", 0.0
    return "", max(below)
