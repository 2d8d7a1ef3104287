"""The robot inside a gait file: complete, so that a gait can be checked and walked without the robot's own file."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from amble.errors import InputError
from amble.io.codec import TEXT, Codec, Count, ListOf, Record
from amble.io.quantities import Array, Interval, Number
from amble.robot.model import NO_OVERLAYS, Foot, Joint, Link, Robot
from amble.types import Json


class _Empty(Codec):
    """A place that is kept for later releases."""

    def encode(self, value: Any, place: str) -> Json:
        """Write an empty object."""
        return self.decode(dict(value), place)

    def decode(self, entry: Any, place: str) -> Json:
        """Refuse what this release does not know."""
        if not isinstance(entry, dict):
            raise InputError(f"{place} is not an object")
        if entry:
            raise InputError(f"{place} is not empty; this release knows neither locked joints, rotors nor payload")
        return {}


def _joint(range: tuple[float, float], **fields: Any) -> Joint:
    lower, upper = range
    return Joint(lower=lower, upper=upper, **fields)


LINK = Record(Link, {"name": TEXT, "mass": Number("kg"), "center": Array("m", 3), "inertia": Array("kg m^2", 3, 3)})

JOINT = Record(
    _joint,
    {
        "name": TEXT,
        "parent": Count(),
        "child": Count(),
        "rotation": Array("1", 3, 3),
        "translation": Array("m", 3),
        "axis": Array("1", 3),
        "range": Interval("rad", infinite=True),
        "effort": Number("N m", infinite=True),
        "velocity": Number("rad/s", infinite=True),
    },
    take=lambda joint: {**vars(joint), "range": (joint.lower, joint.upper)},
)

FOOT = Record(Foot, {"name": TEXT, "frame": TEXT, "link": Count(), "offset": Array("m", 3)})


def _take(robot: Robot) -> Mapping[str, Any]:
    return {**vars(robot), "hash": robot.hash, "overlays": NO_OVERLAYS}


def _build(hash: str, overlays: Json, twins: Any, **fields: Any) -> Robot:
    """Build a robot, and hold it against the hash it was written with."""
    del overlays  # empty, see _Empty
    links = len(fields["links"])
    indices = {
        "child of a joint": [joint.child for joint in fields["joints"]],
        "parent of a joint": [joint.parent for joint in fields["joints"]],
        "link of a foot": [foot.link for foot in fields["feet"]],
    }
    for what, numbers in indices.items():
        for number in numbers:
            if number >= links:
                raise InputError(f"the {what} in the robot of the gait is link {number} of {links}")
    robot = Robot(twins=twins, **fields)
    if links != len(robot.joints) + 1 or robot.hash != hash:
        raise InputError(
            f"gait of another robot: what the file says of '{robot.name}' does not have the hash it was written with"
        )
    return robot


ROBOT = Record(
    _build,
    {
        "name": TEXT,
        "source": TEXT,
        "hash": TEXT,
        "gravity": Number("m/s^2"),
        "symmetry_tolerance": Number("1"),
        "twins": ListOf(ListOf(TEXT, 2)),
        "overlays": Record(dict, dict.fromkeys(NO_OVERLAYS, _Empty())),
        "links": ListOf(LINK),
        "joints": ListOf(JOINT),
        "feet": ListOf(FOOT),
    },
    take=_take,
)
"""Everything of a robot; that it is complete follows from its hash."""
