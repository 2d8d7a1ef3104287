"""What holds of every robot, whether a URDF, a gait file or Python describes it: one tree of bodies that has weight."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from amble.errors import InputError, UnknownNameError, shown
from amble.names import check_distinct
from amble.robot.parts import Foot, Joint, Link, check_bounded

ROUNDING = 1e-9
"""What roundoff may take from a moment of inertia, as a share of the robot's largest, or add to a frame."""

MOST_JOINTS = 100
"""Moving joints of a robot: its mass matrix, and every function of a gait, grows with their square at least."""


def check_numbers(name: str, gravity: float, symmetry_tolerance: float) -> None:
    """Refuse a gravity that does not pull down, and a tolerance that is none.

    Raises:
        InputError: in one sentence.
    """
    check_bounded(f"gravity of robot '{name}'", gravity)
    if not gravity > 0.0:
        raise InputError(f"the gravity of robot '{name}' is {gravity:g} m/s^2; it is a size, along -z, and positive")
    if not 0.0 <= symmetry_tolerance < np.inf:
        raise InputError(
            f"the symmetry tolerance of robot '{name}' is {symmetry_tolerance:g}; it is finite and not negative"
        )


def check_names(
    links: Sequence[Link], joints: Sequence[Joint], feet: Sequence[Foot], twins: Sequence[tuple[str, str]]
) -> None:
    """Refuse two of a kind with one name, and twins that are no two feet.

    Raises:
        UnknownNameError: a twin is no foot.
        InputError: a name occurs twice.
    """
    check_distinct("link", (link.name for link in links))
    check_distinct("joint", (joint.name for joint in joints))
    labels = tuple(foot.name for foot in feet)
    check_distinct("foot", labels)
    for label in (label for pair in twins for label in pair):
        if label not in labels:
            raise UnknownNameError("foot", label, labels)


def check_tree(name: str, links: Sequence[Link], joints: Sequence[Joint], feet: Sequence[Foot]) -> None:
    """Check that the joints carry every link once, and all from the base: what walks along them ends.

    Raises:
        InputError: in one sentence, with the link, joint or foot.
    """
    robot = f"robot '{shown(name)}'"
    if len(joints) > MOST_JOINTS:
        raise InputError(
            f"{robot} has {len(joints)} moving joints, at most {MOST_JOINTS} are computed; lock the others "
            "(locked = { joint = angle } in [robot], or Adaptation(locked=...))"
        )
    if len(links) != len(joints) + 1:
        raise InputError(f"{robot} has {len(links)} links on {len(joints)} joints; there is one more link than joints")
    below: dict[int, list[int]] = {}
    for number, joint in enumerate(joints, start=1):
        if joint.child != number or not 0 <= joint.parent < len(links):
            raise InputError(
                f"joint '{joint.name}' of {robot} is joint {number}, but moves link {joint.child} on link "
                f"{joint.parent}"
            )
        below.setdefault(joint.parent, []).append(number)
    reached = [0]
    for link in reached:  # grows while it is walked
        reached += below.get(link, [])
    if len(reached) < len(links):
        lost = min(set(range(len(links))) - set(reached))
        raise InputError(f"link '{links[lost].name}' of {robot} is in a cycle, not connected to the base")
    _check_feet(robot, links, feet)


def _check_feet(robot: str, links: Sequence[Link], feet: Sequence[Foot]) -> None:
    """Feet on links that joints move, no two of them one point."""
    places: dict[tuple[int, bytes], str] = {}
    for foot in feet:
        if not 0 < foot.link < len(links):
            where = "the base, which no joint moves" if foot.link == 0 else f"link {foot.link} of {len(links)}"
            raise InputError(f"foot '{foot.name}' of {robot} is on {where}")
        place = (foot.link, (np.asarray(foot.offset, dtype=np.float64) + 0.0).tobytes())  # -0.0 is 0.0
        if place in places:
            where = links[foot.link].name
            raise InputError(f"feet '{places[place]}' and '{foot.name}' of {robot} are the same point of '{where}'")
        places[place] = foot.name


def check_frames(joints: Sequence[Joint]) -> None:
    """Refuse frames that are no rotations, axes that are no unit vectors, and limits that are none.

    Raises:
        InputError: in one sentence, with the joint.
    """
    for joint in joints:
        turn = float(np.max(np.abs(joint.rotation.T @ joint.rotation - np.eye(3))))
        if not (turn <= ROUNDING and np.linalg.det(joint.rotation) > 0.0):
            raise InputError(f"the frame of joint '{joint.name}' is no rotation")
        length = float(np.linalg.norm(joint.axis))
        if not abs(length - 1.0) <= ROUNDING:
            raise InputError(f"the axis of joint '{joint.name}' is {length:g} long; it is a unit vector")
        if not joint.lower <= joint.upper:
            raise InputError(f"the range of joint '{joint.name}' is {joint.lower:g} to {joint.upper:g} {joint.unit}")
        for what, most in (("effort", joint.effort), ("velocity", joint.velocity)):
            if not most >= 0.0:
                raise InputError(f"the largest {what} of joint '{joint.name}' is {most:g}; it is not negative")


def check_bodies(links: Sequence[Link]) -> None:
    """Refuse negative masses and inertias of no body; a link may be without mass where others hang on it.

    An inertia that breaks the triangle inequality belongs to no body either, but gives sound equations of motion.

    Raises:
        InputError: in one sentence, with the link.
    """
    largest = max((float(np.max(np.abs(link.inertia))) for link in links), default=0.0) or 1.0
    for link in links:
        if not link.mass >= 0.0:
            raise InputError(f"the mass of link '{link.name}' is {link.mass:g} kg; it is not negative")
        scaled = link.inertia / largest
        if not float(np.max(np.abs(scaled - scaled.T))) <= ROUNDING:
            raise InputError(f"the inertia of link '{link.name}' is not symmetric")
        if not float(np.linalg.eigvalsh(scaled)[0]) >= -ROUNDING:
            smallest = float(np.linalg.eigvalsh(link.inertia)[0])
            raise InputError(
                f"the inertia of link '{link.name}' is not positive definite "
                f"(smallest principal moment {smallest:.3g} kg m^2)"
            )
