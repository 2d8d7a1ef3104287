"""Gaits as files: one JSON, versioned, complete, every number with its unit; no pickle, no solver needed to read it.

``codec.GAIT`` describes the file once, for writing and for reading; docs/gait-format.md explains every key.
"""

from __future__ import annotations

import hashlib
import json
from pathlib import Path

from amble.errors import InputError, printable, shown, shown_path
from amble.gait.codec import GAIT
from amble.gait.record import Gait
from amble.io.reader import read_json
from amble.io.storage import atomic_write, dumps
from amble.robot import Robot
from amble.types import Json

FORMAT = "amble gait"
FORMAT_VERSION = 3
READERS = {1: "0.1.0", 2: "0.1.0"}
"""Earlier format version -> the last release that reads it."""

CONTENT = (
    "robot",
    "pattern",
    "ground",
    "contact",
    "phase",
    "outputs",
    "control_law",
    "allocation_law",
    "landing_rule",
    "speed",
    "lateral_speed",
    "yaw_rate",
    "limits",
    "domains",
    "feedback",
)
"""Parts of the file that determine the closed loop and what it is held against; not how it was found."""


def save_gait(gait: Gait, path: str | Path) -> Path:
    """Write a gait to a JSON file, in one step; floats read back exactly. Returns the path.

    Raises:
        InputError: the gait could not be read back, or the place cannot be written.
    """
    header = {"format": FORMAT, "format_version": FORMAT_VERSION}
    return atomic_write(path, dumps({**header, **to_dict(gait)}) + "\n")


def load_gait(path: str | Path, robot: Robot | None = None) -> Gait:
    """Read a gait.

    The file holds the whole robot, so its URDF is not needed.

    Args:
        path: file that ``save_gait`` wrote.
        robot: the robot that the caller believes it is; where not given, no more is checked than that the robot in
            the file has the hash it was written with.

    Raises:
        InputError: in one sentence, where the file is missing, truncated, of another version, or was written for
            another robot; where a key is missing or unknown, a unit or a shape differs, or a number is not finite.
    """
    tree = read_json(path, "gait file")
    name = f"gait file '{shown_path(path)}'"
    if tree.pop("format", None) != FORMAT:
        raise InputError(f"'{shown_path(path)}' is not a gait file")
    version = tree.pop("format_version", None)
    if version != FORMAT_VERSION or isinstance(version, bool):
        release = READERS.get(version) if type(version) is int else None
        reader = f"amble {release} reads it" if release else f"this release reads {FORMAT_VERSION}"
        stated = repr(version) if isinstance(version, str) else version  # the text "3" is not the number
        raise InputError(f"{name} has format version {shown(stated)}; {reader}")
    gait = from_dict(tree, f"gait file '{printable(Path(path).name)}'")
    _same_robot(gait.robot, robot, name)
    return gait


def to_dict(gait: Gait) -> Json:
    """Return everything that a gait is as its file has it, without format and format version."""
    return GAIT.encode(gait, "the gait")


def from_dict(tree: Json, place: str = "the gait") -> Gait:
    """Build a gait from what ``to_dict`` returned; errors as in ``load_gait``."""
    return GAIT.decode(tree, place)


def content_hash(gait: Gait) -> str:
    """Return the SHA-256 of what determines the closed loop and what it is held against; not of how it was found.

    Keys that later releases add are written only where they are used, so a gait of today keeps its hash.
    """
    tree = to_dict(gait)
    content = json.dumps({part: tree[part] for part in CONTENT if part in tree}, sort_keys=True, allow_nan=False)
    return hashlib.sha256(content.encode()).hexdigest()


def _same_robot(written_for: Robot, given: Robot | None, name: str) -> None:
    if given is not None and given != written_for:
        raise InputError(
            f"gait of another robot: {name} was written for '{written_for.name}' (hash {written_for.hash[:12]}), "
            f"not for '{given.name}' (hash {given.hash[:12]})"
        )
