"""The robot inside a gait file: complete, so that a gait can be checked and walked without the robot's own file."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from amble.errors import InputError, UnknownNameError, shown
from amble.io.codec import TEXT, ByName, Codec, Count, ListOf, Record
from amble.io.quantities import Array, Interval, Number
from amble.robot.model import Robot
from amble.robot.parts import DRIVE, Foot, Joint, Link, Payload
from amble.types import Json


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

DRIVEN = Record(
    dict,
    {
        "rotor_inertia": Number("kg m^2"),
        "damping": Number("N m s/rad"),
        "dry_friction": Number("N m"),
        "friction_width": Number("rad/s"),
    },
)
"""What stands between a joint's torque and its motion."""

PAYLOAD = Record(Payload, {"mass": Number("kg"), "position": Array("m", 3), "link": TEXT})


class _Payload(Codec):
    """A payload, or an empty object where nothing is carried."""

    def encode(self, value: Any, place: str) -> Json:
        """Write the payload."""
        return {} if value is None else PAYLOAD.encode(value, place)

    def decode(self, entry: Any, place: str) -> Payload | None:
        """Read the payload."""
        if entry == {}:
            return None
        payload: Payload = PAYLOAD.decode(entry, place)
        return payload


OVERLAYS = Record(
    dict,
    {"locked_joints": ByName("joint", Number("rad or m")), "rotors": ByName("joint", DRIVEN), "payload": _Payload()},
)
"""What is laid over links and joints; three empty objects where nothing is."""

FOOT = Record(Foot, {"name": TEXT, "frame": TEXT, "link": Count(), "offset": Array("m", 3)})


def _take(robot: Robot) -> Mapping[str, Any]:
    overlays = {
        "locked_joints": robot.locked_joints,
        "rotors": {
            joint.name: {what: getattr(joint, what) for what in DRIVE}
            for joint in robot.joints
            if not joint.driven_freely
        },
        "payload": robot.payload,
    }
    return {**vars(robot), "hash": robot.hash, "overlays": overlays}


def _build(hash: str, overlays: Json, joints: tuple[Joint, ...], **fields: Any) -> Robot:
    """Build a robot, and hold it against the hash it was written with."""
    _check_tree(fields["links"], joints, fields["feet"])
    names, rotors = [joint.name for joint in joints], overlays["rotors"]
    for name in rotors:
        if name not in names:
            raise UnknownNameError("joint (rotors of the robot of the gait)", name, names)
    robot = Robot(
        joints=tuple(replace(joint, **rotors.get(joint.name, {})) for joint in joints),
        locked_joints=overlays["locked_joints"],
        payload=overlays["payload"],
        **fields,
    )
    if robot.hash != hash:
        raise InputError(
            f"gait of another robot: what the file says of '{robot.name}' does not have the hash it was written with"
        )
    return robot


def _check_tree(links: tuple[Link, ...], joints: tuple[Joint, ...], feet: tuple[Foot, ...]) -> None:
    """Check that the joints carry every link once, and all from the base: what walks along them ends."""
    place = "the robot of the gait"
    if len(links) != len(joints) + 1:
        raise InputError(f"{place} has {len(links)} links on {len(joints)} joints; there is one more link than joints")
    for foot in feet:
        if foot.link >= len(links):
            raise InputError(f"the link of foot '{shown(foot.name)}' in {place} is link {foot.link} of {len(links)}")
    below: dict[int, list[int]] = {}
    for number, joint in enumerate(joints, start=1):
        if joint.child != number or joint.parent >= len(links):
            name, child, parent = shown(joint.name), joint.child, joint.parent
            raise InputError(f"joint '{name}' in {place} is joint {number}, but moves link {child} on link {parent}")
        below.setdefault(joint.parent, []).append(number)
    reached = [0]
    for link in reached:  # grows while it is walked
        reached += below.get(link, [])
    if len(reached) < len(links):
        lost = min(set(range(len(links))) - set(reached))
        raise InputError(f"link '{shown(links[lost].name)}' in {place} is in a cycle, not connected to the base")


ROBOT = Record(
    _build,
    {
        "name": TEXT,
        "source": TEXT,
        "hash": TEXT,
        "gravity": Number("m/s^2"),
        "symmetry_tolerance": Number("1"),
        "twins": ListOf(ListOf(TEXT, 2)),
        "overlays": OVERLAYS,
        "links": ListOf(LINK),
        "joints": ListOf(JOINT),
        "feet": ListOf(FOOT),
    },
    take=_take,
)
"""Everything of a robot; that it is complete follows from its hash."""
