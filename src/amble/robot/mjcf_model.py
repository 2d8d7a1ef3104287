"""What MuJoCo makes of an MJCF file, compiled in a process of its own (``mjcf_worker``), with the files it may use.

An included file and a mesh whose inertia counts are read where they lie in the folder of the file or below; any other
file that a file names is not opened, and where it is needed the file is refused.
"""

from __future__ import annotations

import json
import logging
import os
import tempfile
from collections.abc import Iterable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any
from xml.etree import ElementTree

import numpy as np

from amble.errors import InputError, shown, shown_path
from amble.io.reader import read_bytes
from amble.io.worker import by_worker
from amble.io.xml import parse_xml
from amble.optional import require
from amble.robot.parts import check_bounded
from amble.robot.urdf import LARGEST
from amble.types import Json

SECONDS, MEMORY = 5, 2**30
"""Processor time and bytes that a file may take."""

MOST_BODIES = 5000
LARGEST_MESH, MOST_FILES = 2**26, 1000
MOST_BYTES = 2**27
"""Of one mesh, of how many files a file may use, and of all of them together: one file goes by many names."""

PARTS = ("include", "model")
"""Elements whose file is MJCF again."""

logger = logging.getLogger("amble")


def compiled(path: Path) -> Any:
    """Return the compiled model of a file: arrays as MuJoCo names them, ``names`` by kind, ``name``, ``tendons``.

    Raises:
        MissingExtraError: mujoco is not installed.
        InputError: MuJoCo does not compile the file, in time and memory, or it needs a file outside its folder.
    """
    require("mujoco", "mujoco", "MJCF files")
    name, content = f"robot file '{shown_path(path)}'", read_bytes(path, "robot file", LARGEST)
    parts = _bounded((("include", label, text) for label, text in _included(path, content, name)), name)
    found = _asked(name, content, parts)
    if "needs" in found:
        needs = found["needs"][:MOST_FILES]
        meshes = (("mesh", file, _mesh(path, file, found["folders"], name)) for file in needs)
        found = _asked(name, content, [*parts, *_bounded(meshes, name)])
    for text in found["said"]:
        logger.warning("%s: MuJoCo warns: %s", path.name, shown(text))
    if "arrays" not in found:
        raise InputError(
            f"{name}: MuJoCo does not compile it: {shown(found.get('refused', 'meshes are missing'), 200)}"
        )
    arrays = {key: np.array(values) for key, values in found["arrays"].items()}
    for key, values in arrays.items():  # before anything is computed with them: 1e308 squared is no number
        if values.dtype.kind == "f":
            check_bounded(f"{key} of {name}", values)
    return SimpleNamespace(name=found["name"], names=found["names"], tendons=found["tendons"], **arrays)


def _asked(name: str, content: bytes, parts: Iterable[tuple[str, str, bytes]]) -> Json:
    parts = list(parts)
    wanted = {
        "size": len(content),
        "parts": [(kind, label, len(text)) for kind, label, text in parts],
        "most": MOST_BODIES,
        "seconds": SECONDS,
        "bytes": MEMORY,
    }
    with tempfile.TemporaryFile() as stream:
        stream.write(content)
        for _, _, text in parts:
            stream.write(text)
        stream.seek(0)
        found: Json = json.loads(by_worker(Path(__file__).with_name("mjcf_worker.py"), wanted, stream, name))
    return found


def _bounded(parts: Iterable[tuple[str, str, bytes]], name: str) -> list[tuple[str, str, bytes]]:
    """Collect the files that a file uses while they are not too much."""
    found, size = list[tuple[str, str, bytes]](), 0
    for part in parts:
        size += len(part[2])
        if size > MOST_BYTES:
            raise InputError(f"{name} uses files of more than {MOST_BYTES / 2**20:g} MB")
        found.append(part)
    return found


def _included(path: Path, content: bytes, name: str) -> Iterator[tuple[str, bytes]]:
    """Yield the files that a file includes, and those that these include, each once."""
    seen, waiting = set[str](), [content]
    while waiting:
        for label in _named(waiting.pop(), name):
            if label in seen:
                continue
            seen.add(label)
            if len(seen) > MOST_FILES:
                raise InputError(f"{name} includes more than {MOST_FILES} files")
            text = read_bytes(_inside(path, [label], name), "robot file", LARGEST)
            yield label, text
            waiting.append(text)


def _named(content: bytes, name: str) -> list[str]:
    """Return the files that a text includes."""
    try:
        root = parse_xml(content)
    except (ElementTree.ParseError, ValueError, LookupError) as error:  # the latter of an encoding that there is not
        raise InputError(f"{name} is not well-formed XML: {shown(str(error))}") from error
    return [element.get("file", "") for element in root.iter() if element.tag in PARTS and element.get("file")]


def _mesh(path: Path, file: str, folders: Iterable[str], name: str) -> bytes:
    """Read a mesh file below the folder that the compiler element names, or beside the file."""
    places = [*(str(Path(folder) / file) for folder in folders), file]
    return read_bytes(_inside(path, places, name), "mesh file", LARGEST_MESH)


def _inside(path: Path, places: list[str], name: str) -> Path:
    """Return the first of some places that there is, below the folder of a file.

    Raises:
        InputError: there is none, or it lies elsewhere.
    """
    folder, elsewhere = Path(os.path.realpath(path)).parent, False
    for place in places:
        if "\0" in place:
            continue
        found = Path(os.path.realpath(folder / place))
        if not found.is_relative_to(folder):
            elsewhere = True
        elif os.path.isfile(found):  # which says no where the name is too long
            return found
    what = shown(places[-1])
    if elsewhere:
        raise InputError(
            f"{name} names the file '{what}' outside its folder, which is not read: copy it into the folder; a mesh is "
            "not needed where the inertia of its body is written (inertial)"
        )
    raise InputError(f"{name} needs the file '{what}', which is not there")
