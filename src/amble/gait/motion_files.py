"""Motions as tables that other programs read and write: npz, CSV and MATLAB's mat, by the suffix of the file.

A gait that is written here holds the whole of its file but the motion as one text of JSON, and the motion as plain
arrays: read again it is the same gait. A file from elsewhere needs times and coordinates only (docs/gaits.md).
"""

from __future__ import annotations

import json
from pathlib import Path

from amble.errors import InputError, printable, shown
from amble.gait.files import from_dict, to_dict
from amble.gait.motion_formats import FORMATS, Format
from amble.gait.record import Gait
from amble.gait.recorded import FIELDS, RecordedMotion
from amble.io.storage import atomic_write


def write_motion(gait: Gait, path: str | Path) -> Path:
    """Write a gait as npz, csv or mat, by the suffix, in one step. Returns the path.

    Raises:
        InputError: the suffix is another one, or the place cannot be written.
    """
    tree = to_dict(gait)
    for domain in gait.domains:
        for field in FIELDS:
            del tree["domains"][domain.name][field]["value"]
    text = json.dumps(tree, allow_nan=False)
    return atomic_write(path, _format(path).write(gait, text))


def read_motion(path: str | Path) -> RecordedMotion:
    """Read a motion of npz, csv or mat, by the suffix.

    Raises:
        InputError: in one sentence, where the file is missing, damaged, too large, or lacks what a motion needs.
    """
    motion = _format(path).read(path)
    motion.check()
    return motion


def recorded_gait(motion: RecordedMotion) -> Gait:
    """Return the gait of a file that amble wrote.

    Raises:
        InputError: the file is from elsewhere, or what it holds is no gait.
    """
    name = f"motion '{printable(motion.source)}'"
    if motion.header is None:
        raise InputError(f"{name} does not say of which robot and gait it is; give a specification that does")
    tree = dict(motion.header)
    entries = tree.get("domains")
    if not isinstance(entries, dict) or set(entries) != {domain.name for domain in motion.domains}:
        raise InputError(f"{name} holds other domains than its header names")
    for domain in motion.domains:
        entry = entries[domain.name]
        for field in FIELDS:
            values = getattr(domain, field)
            if values is None or not isinstance(entry, dict) or not isinstance(entry.get(field), dict):
                raise InputError(f"{name} has no {field} of domain '{shown(domain.name)}'")
            entry[field]["value"] = values.tolist()
    return from_dict(tree, name)


def _format(path: str | Path) -> Format:
    suffix = Path(path).suffix.lower()
    if suffix not in FORMATS:
        raise InputError(f"'{printable(Path(path).name)}' is no motion by its suffix; known: {', '.join(FORMATS)}")
    return FORMATS[suffix]
