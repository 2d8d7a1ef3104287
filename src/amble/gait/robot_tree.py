"""The robot inside a gait file: complete, so that a gait can be checked and walked without the robot's own file."""

from __future__ import annotations

from amble.errors import InputError
from amble.io.codec import Reader, quantity
from amble.robot import Foot, Joint, Link, Robot
from amble.types import Json


def robot_tree(robot: Robot) -> Json:
    """Write a robot as a tree of named quantities with units."""
    return {
        "name": robot.name,
        "source": robot.source,
        "hash": robot.hash,
        "gravity": quantity(robot.gravity, "m/s^2"),
        "symmetry_tolerance": quantity(robot.symmetry_tolerance, "1"),
        "twins": [list(pair) for pair in robot.twins],
        "links": [
            {
                "name": link.name,
                "mass": quantity(link.mass, "kg"),
                "center": quantity(link.center, "m"),
                "inertia": quantity(link.inertia, "kg m^2"),
            }
            for link in robot.links
        ],
        "joints": [
            {
                "name": joint.name,
                "parent": joint.parent,
                "child": joint.child,
                "rotation": quantity(joint.rotation, "1"),
                "translation": quantity(joint.translation, "m"),
                "axis": quantity(joint.axis, "1"),
                "range": quantity((joint.lower, joint.upper), "rad"),
                "effort": quantity(joint.effort, "N m"),
                "velocity": quantity(joint.velocity, "rad/s"),
            }
            for joint in robot.joints
        ],
        "feet": [
            {"name": foot.name, "frame": foot.frame, "link": foot.link, "offset": quantity(foot.offset, "m")}
            for foot in robot.feet
        ],
    }


def robot_from(reader: Reader) -> Robot:
    """Read a robot back.

    Raises:
        InputError: something is missing, or the robot is not the one whose hash was written.
    """
    reader.expect("name", "source", "hash", "gravity", "symmetry_tolerance", "twins", "links", "joints", "feet")
    links = tuple(_link(entry) for entry in reader.each("links"))
    robot = Robot(
        name=reader.text("name"),
        source=reader.text("source"),
        links=links,
        joints=tuple(_joint(entry, len(links)) for entry in reader.each("joints")),
        feet=tuple(_foot(entry, len(links)) for entry in reader.each("feet")),
        gravity=reader.number("gravity", "m/s^2"),
        twins=_twins(reader),
        symmetry_tolerance=reader.number("symmetry_tolerance", "1"),
    )
    if len(links) != len(robot.joints) + 1 or robot.hash != reader.text("hash"):
        raise InputError(
            f"gait of another robot: what the file says of '{robot.name}' does not have the hash it was written with"
        )
    return robot


def _link(entry: Reader) -> Link:
    entry.expect("name", "mass", "center", "inertia")
    return Link(
        entry.text("name"),
        entry.number("mass", "kg"),
        entry.array("center", "m", (3,)),
        entry.array("inertia", "kg m^2", (3, 3)),
    )


def _joint(entry: Reader, links: int) -> Joint:
    entry.expect("name", "parent", "child", "rotation", "translation", "axis", "range", "effort", "velocity")
    lower, upper = entry.pair("range", "rad", infinite=True)
    return Joint(
        name=entry.text("name"),
        parent=_index(entry, "parent", links),
        child=_index(entry, "child", links),
        rotation=entry.array("rotation", "1", (3, 3)),
        translation=entry.array("translation", "m", (3,)),
        axis=entry.array("axis", "1", (3,)),
        lower=lower,
        upper=upper,
        effort=entry.number("effort", "N m", infinite=True),
        velocity=entry.number("velocity", "rad/s", infinite=True),
    )


def _foot(entry: Reader, links: int) -> Foot:
    entry.expect("name", "frame", "link", "offset")
    return Foot(entry.text("name"), entry.text("frame"), _index(entry, "link", links), entry.array("offset", "m", (3,)))


def _index(entry: Reader, key: str, size: int) -> int:
    index = entry.count(key)
    if not 0 <= index < size:
        raise InputError(f"a {key} in the robot of the gait is link {index} of {size}")
    return index


def _twins(reader: Reader) -> tuple[tuple[str, str], ...]:
    pairs = reader.raw("twins")
    fits = isinstance(pairs, list) and all(
        isinstance(pair, list) and len(pair) == 2 and all(isinstance(foot, str) for foot in pair) for pair in pairs
    )
    if not fits:
        raise InputError("the twins in the robot of the gait are not pairs of feet")
    return tuple((left, right) for left, right in pairs)
