"""Motions of other programs: npz, CSV and mat files that amble wrote, with damage to arrays, text and bytes."""

from __future__ import annotations

import io
import json
import random
import tempfile
import zipfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from fuzz import gait_bases
from fuzz.bytes import damaged
from fuzz.trees import as_json, damage
from fuzz.words import LITERALS, NAMES

SUFFIXES = (".npz", ".csv", ".mat")
TYPES = ("f4", "i8", "c16", "?", "O", "U5", "S3", "M8[s]", "f8,i4")


@cache
def written(suffix: str, number: int) -> bytes:
    """A motion in a file of a format."""
    from amble.gait.files import load_gait
    from amble.gait.motion_files import write_motion

    with tempfile.TemporaryDirectory() as folder:
        (Path(folder) / "gait.json").write_text(gait_bases.small(number), encoding="utf-8")
        return write_motion(load_gait(Path(folder) / "gait.json"), Path(folder) / f"motion{suffix}").read_bytes()


def drawer(suffix: str) -> Callable[[random.Random], tuple[bytes, list[str]]]:
    """Return what draws a motion of a format."""

    def draw(chance: random.Random) -> tuple[bytes, list[str]]:
        content = written(suffix, chance.randrange(12))
        done: list[str] = []
        if suffix == ".npz" and chance.random() < 0.7:
            content = _arrays(content, chance, done)
        if suffix == ".csv" and chance.random() < 0.7:
            content = _cells(content, chance, done)
        if suffix == ".mat" and chance.random() < 0.5:
            content = _variables(content, chance, done)
        if not done or chance.random() < 0.1:
            for _ in range(chance.choice((1, 1, 3))):
                content, what = damaged(content, chance)
                done.append(what)
        return content, done

    return draw


def read_motion(path: Path) -> Any:
    """Read a motion as the gait that it says it is."""
    from amble.gait import motion_files

    return motion_files.recorded_gait(motion_files.read_motion(path))


def _other_array(values: Any, chance: random.Random) -> Any:
    kind = chance.choice(("type", "shape", "number", "none", "text"))
    if kind == "type":
        return np.zeros(np.shape(values), chance.choice(TYPES))
    if kind == "shape":
        return np.reshape(values, (1, -1)) if chance.random() < 0.5 else np.ravel(values)[: chance.randrange(9)]
    if kind == "number" and np.asarray(values).dtype.kind == "f" and np.size(values):
        changed = np.array(values)
        changed.flat[chance.randrange(changed.size)] = chance.choice((np.nan, np.inf, 1e300, -1e13, 0.0))
        return changed
    return np.array(chance.choice(NAMES)) if kind == "text" else np.zeros((0, 3))


def _arrays(content: bytes, chance: random.Random, done: list[str]) -> bytes:
    """Arrays of other types, shapes and names; now and then a header that promises more than there is."""
    with np.load(io.BytesIO(content)) as file:
        arrays: dict[str, Any] = dict(file)
    for _ in range(chance.choice((1, 1, 2))):
        key = chance.choice(list(arrays))
        kind = chance.choice(("array", "gone", "name", "header"))
        done.append(f"{kind} {key}")
        if kind == "array":
            arrays[key] = _other_array(arrays[key], chance)
        elif kind == "gone":
            del arrays[key]
        elif kind == "name":
            arrays[chance.choice(NAMES).replace("/", "") or "x"] = arrays.pop(key)
        else:
            text = next((name for name in arrays if arrays[name].shape == () and arrays[name].dtype.kind == "U"), None)
            if text is not None:
                try:
                    tree = json.loads(str(arrays[text]))
                except ValueError:
                    tree = {"a": {}}
                damage(tree, chance)
                arrays[text] = np.array(as_json(tree, chance).decode("utf-8", "surrogatepass"))
        if not arrays:
            break
    stream = io.BytesIO()
    with zipfile.ZipFile(stream, "w", chance.choice((zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED))) as archive:
        for name, values in arrays.items():
            part = io.BytesIO()
            np.lib.format.write_array(part, np.asarray(values), allow_pickle=True)
            data = part.getvalue()
            if chance.random() < 0.05:
                data = data.replace(b"'shape': (", b"'shape': (9999999999999,", 1)
                done.append(f"promise {name}")
            entry = f"{name.encode('utf-8', 'replace').decode()}.npy".replace("\0", "_")
            archive.writestr(zipfile.ZipInfo(entry), data, archive.compression)  # which is without the time of day
    return stream.getvalue()


def _cells(content: bytes, chance: random.Random, done: list[str]) -> bytes:
    """Cells, columns and rows of another text or number."""
    rows = [line.split(",") for line in content.decode().split("\n")]
    for _ in range(chance.choice((1, 1, 2, 4))):
        row = chance.choice(rows[1:]) if chance.random() < 0.8 else rows[0]
        at = chance.randrange(len(row))
        kind = chance.choice(("cell", "gone", "quote", "long"))
        done.append(kind)
        if kind == "gone":
            del row[at]
        elif kind == "cell":
            row[at] = chance.choice((*NAMES, *LITERALS[:20]))
        else:
            row[at] = '"' + row[at] if kind == "quote" else "9" * 200_000
        if not row:
            row.append("")
    return "\n".join(",".join(row) for row in rows).encode("utf-8", "surrogatepass")


def _variables(content: bytes, chance: random.Random, done: list[str]) -> bytes:
    """A struct with other entries, or another variable in its place."""
    from scipy.io import loadmat, savemat

    found = {key: value for key, value in loadmat(io.BytesIO(content)).items() if not key.startswith("__")}
    key = chance.choice(list(found))
    done.append(f"variable {key}")
    if key == "gait" and chance.random() < 0.8:
        entry = found[key].ravel()[chance.randrange(found[key].size)]
        field = chance.choice(entry.dtype.names)
        entry[field] = _other_array(np.zeros((3, 4)), chance)
        done.append(field)
    else:
        found[key] = _other_array(found[key] if key != "gait" else np.zeros((2, 2)), chance)
    stream = io.BytesIO()
    try:
        savemat(stream, found, do_compression=chance.random() < 0.5)
    except (TypeError, ValueError, UnicodeEncodeError):  # nothing that MATLAB has
        done.append("not written")
        return content[: chance.randrange(len(content))]
    return content[:116] + stream.getvalue()[116:]  # there SciPy writes the date
