"""Formats of robot files: each is a function that reads links and joints as written; the rest of loading is shared."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np

from amble.errors import InputError, shown
from amble.io.registry import Lookup
from amble.robot.mjcf import read_mjcf, read_xml
from amble.robot.urdf import FileJoint, FileLink, FileRobot, read_urdf

__all__ = ["READERS", "FileJoint", "FileLink", "FileRobot", "format_of", "read_robot"]

READERS: Lookup[Callable[[Path], FileRobot]] = Lookup("format of robot files")
"""The formats of robot files by the suffix of their names, without the dot."""

READERS.register("urdf", read_urdf)
READERS.register("mjcf", read_mjcf)
READERS.register("xml", read_xml)

SHAPES = {"center": (3,), "inertia": (3, 3), "rotation": (3, 3), "translation": (3,), "axis": (3,)}


def format_of(path: Path) -> str | None:
    """Return the format that the suffix of a file's name says; None where it says none."""
    suffix = path.suffix.removeprefix(".").lower()
    return suffix if suffix in READERS else None


def read_robot(path: Path, format: str | None = None) -> FileRobot:
    """Read a robot file by the reader of its format.

    Args:
        path: the file.
        format: name of the format; by default the suffix of the file's name, and URDF where no format has it.

    Raises:
        UnknownNameError: there is no reader of that name.
        InputError: the reader refuses the file, or it holds no link, a name twice, or a number that is not finite.
    """
    file = READERS[format or format_of(path) or "urdf"](path)
    for kind, names in (("link", [link.name for link in file.links]), ("joint", [joint.name for joint in file.joints])):
        twice = sorted(name for name, count in Counter(names).items() if count > 1)
        if twice:
            raise InputError(f"{path.name}: {kind} '{shown(twice[0])}' is defined more than once")
    if not file.links:
        raise InputError(f"{path.name}: the robot has no link")
    for link in file.links:
        _check_arrays(f"{path.name}: link '{shown(link.name)}'", link)
        if not np.isfinite(link.mass):
            raise InputError(f"{path.name}: the mass of link '{shown(link.name)}' is {link.mass}, not a finite number")
    for joint in file.joints:
        _check_arrays(f"{path.name}: joint '{shown(joint.name)}'", joint)
    return file


def _check_arrays(place: str, part: FileLink | FileJoint) -> None:
    for field, shape in SHAPES.items():
        values = getattr(part, field, None)
        if values is not None and not (np.shape(values) == shape and np.all(np.isfinite(values))):
            raise InputError(f"{place}: its {field} is not {' x '.join(map(str, shape))} finite numbers")
