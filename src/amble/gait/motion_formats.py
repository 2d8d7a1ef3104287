"""Formats of a motion: npz, CSV, and MATLAB's mat with the fields that FROST has."""

from __future__ import annotations

import io
import warnings
import zipfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from amble.errors import InputError, printable, shown
from amble.gait.record import Gait
from amble.gait.recorded import FIELDS, HEADER, LARGEST, MOST_NAMES, RecordedDomain, RecordedMotion
from amble.io.reader import opened, parse_json, parse_number, read_bytes
from amble.io.table import read_table, table_text
from amble.io.worker import by_worker
from amble.types import Json

FROST = {
    "times": ("tspan",),
    "positions": ("states", "x"),
    "velocities": ("states", "dx"),
    "accelerations": ("states", "ddx"),
}
"""Fields of FROST's gait, one column a sample there; inputs of other programs are not read, since frames differ."""

OWN = {"torques": ("inputs", "u"), "forces": ("inputs", "f")}
"""Fields that are there too where amble wrote the file."""


Found = TypeVar("Found")

MAT_TITLE = b"MATLAB 5.0 MAT-file, written by amble".ljust(116)
"""How a mat file begins: any text."""

ENTRY = b"PK\x01\x02"
"""How an entry in the directory of a zip file begins: without one no file is found."""

SECONDS, BYTES_A_SECOND = 5, 20 * 2**20
"""Processor time in which a mat file is read: what a small one may take, and how much of a large one in a second."""


@dataclass(frozen=True)
class Format:
    """How a motion is written from a gait and the text of the rest of it, and how it is read."""

    write: Callable[[Gait, str], bytes]
    read: Callable[[str | Path], RecordedMotion]


def _write_npz(gait: Gait, text: str) -> bytes:
    arrays = {f"{domain.name}.{field}": getattr(domain, field) for domain in gait.domains for field in FIELDS}
    stream = io.BytesIO()
    np.savez(stream, **{HEADER: np.array(text), "coordinates": np.array(gait.robot.coordinate_names), **arrays})
    return stream.getvalue()


def _read_npz(path: str | Path) -> RecordedMotion:
    name = Path(path).name
    data = read_bytes(path, "motion", LARGEST)
    if data.count(ENTRY) > MOST_NAMES:
        raise InputError(f"motion '{printable(name)}' holds more than {MOST_NAMES} arrays")

    def read() -> dict[str, Any]:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > LARGEST:
                raise InputError(f"motion '{printable(name)}' unpacks to more than {LARGEST} bytes")
        with np.load(io.BytesIO(data), allow_pickle=False) as found:
            return {key: np.asarray(found[key]) for key in found.files}

    arrays = _by_library(read, name, "npz file")
    header = arrays.pop(HEADER, None)
    columns = arrays.pop("coordinates", None)
    parts: dict[str, dict[str, Any]] = {}
    for key, values in arrays.items():
        domain, dot, field = key.rpartition(".")
        if not dot or field not in FIELDS:
            raise InputError(
                f"motion '{printable(name)}': unknown array '{shown(key)}'; known: DOMAIN.{', '.join(FIELDS)}"
            )
        parts.setdefault(domain, {})[field] = _numbers(values, name, key)
    return RecordedMotion(
        name,
        _domains(parts, name),
        _header(None if header is None else str(header), name),
        None if columns is None else _titles(columns, name),
    )


def _titles(columns: Any, name: str) -> tuple[str, ...]:
    """Return the names of coordinates."""
    if columns.dtype.kind != "U" or columns.size > MOST_NAMES:
        raise InputError(f"motion '{printable(name)}': its coordinates are no names, or more than {MOST_NAMES}")
    return tuple(map(str, columns.ravel()))


def _by_library(read: Callable[[], Found], name: str, what: str) -> Found:
    """Read by a library of others: what a damaged file makes it raise has many names, and all are one sentence."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            return read()
    except InputError:
        raise
    except Exception as error:
        raise InputError(f"motion '{printable(name)}' is no {what}: {shown(str(error))}") from None


def _write_csv(gait: Gait, text: str) -> bytes:
    names, feet = gait.robot.coordinate_names, gait.pattern.all_contacts.labels
    head = ["domain", "time", *_columns(names), *(f"torque {j}" for j in gait.robot.joint_names)]
    rows: list[list[str]] = [[*head, *(f"force {label}" for label in feet)]]
    for domain in gait.domains:
        places = gait.pattern.contacts(gait.pattern.stance(domain.name)).columns
        for row in range(len(domain.times)):
            forces = [""] * len(feet)
            for place, value in zip(places, domain.forces[row], strict=True):
                forces[place] = repr(float(value))
            numbers = [domain.times[row], *domain.positions[row], *domain.velocities[row], *domain.accelerations[row]]
            values = [repr(float(value)) for value in (*numbers, *domain.torques[row])]
            rows.append([domain.name, *values, *forces])
    return f"# {HEADER} {text}\n{table_text(rows)}".encode()


def _columns(names: Sequence[str]) -> list[str]:
    return [*names, *(f"rate of {name}" for name in names), *(f"acceleration of {name}" for name in names)]


def _read_csv(path: str | Path) -> RecordedMotion:
    name = Path(path).name
    comment, table = read_table(path, "motion")
    header = comment.removeprefix(f"{HEADER} ") if comment.startswith(f"{HEADER} ") else None
    head, *rows = table or [[]]
    if head[:2] != ["domain", "time"]:
        raise InputError(f"motion '{printable(name)}': its columns begin with domain and time, then the coordinates")
    kinds = {"rate of ": "velocities", "acceleration of ": "accelerations", "torque ": "torques", "force ": "forces"}
    titles = head[2:]
    field_of = [
        next((kind for start, kind in kinds.items() if title.startswith(start)), "positions") for title in titles
    ]
    by_domain: dict[str, list[list[str]]] = {}
    for number, row in enumerate(rows, start=2):
        if len(row) != len(head):
            raise InputError(f"motion '{printable(name)}': row {number} has {len(row)} cells, not {len(head)}")
        by_domain.setdefault(row[0], []).append(row[1:])
    if len(by_domain) > MOST_NAMES:
        raise InputError(f"motion '{printable(name)}' has more than {MOST_NAMES} domains")
    parts: dict[str, dict[str, Any]] = {}
    for domain, lines in by_domain.items():
        fields: dict[str, Any] = {"times": _parsed([[line[0]] for line in lines], name, "time")}
        for field in dict.fromkeys(field_of):
            chosen = [place for place, kind in enumerate(field_of, start=1) if kind == field]
            kept = [place for place in chosen if field != "forces" or any(line[place] for line in lines)]
            fields[field] = _parsed([[line[place] for place in kept] for line in lines], name, field)
        parts[domain] = fields
    coordinates = tuple(title for title, field in zip(titles, field_of, strict=True) if field == "positions")
    return RecordedMotion(name, _domains(parts, name), _header(header, name), coordinates)


def _write_mat(gait: Gait, text: str) -> bytes:
    from scipy.io import savemat

    entries = np.empty(
        (1, len(gait.domains)), dtype=[(key, object) for key in ("name", "tspan", "states", "inputs", "params")]
    )
    for place, domain in enumerate(gait.domains):
        states = {"x": domain.positions.T, "dx": domain.velocities.T, "ddx": domain.accelerations.T}
        inputs = {"u": domain.torques.T, "f": domain.forces.T}
        params = {"a": domain.coefficients, "duration": domain.duration}
        entries[0, place] = (domain.name, domain.times[None], states, inputs, params)
    stream = io.BytesIO()
    savemat(stream, {"gait": entries, HEADER: text, "coordinates": np.array(gait.robot.coordinate_names, dtype=object)})
    return MAT_TITLE + stream.getvalue()[len(MAT_TITLE) :]  # SciPy's own holds the date


def _read_mat(path: str | Path) -> RecordedMotion:
    name = Path(path).name
    with opened(path, "motion", LARGEST) as (stream, size):
        wanted = {
            "texts": (HEADER, "coordinates"),
            "fields": FROST,
            "own": OWN,
            "seconds": SECONDS + size // BYTES_A_SECOND,
            "bytes": 4 * LARGEST,
            "most": MOST_NAMES,
        }
        found = by_worker(Path(__file__).with_name("mat_worker.py"), wanted, stream, f"motion '{printable(name)}'")
    with np.load(io.BytesIO(found)) as file:
        arrays = dict(file)
    if "refused" in arrays:
        raise InputError(f"motion '{printable(name)}' {shown(str(arrays['refused']))}")
    header, columns = arrays.get(HEADER), arrays.get("coordinates")
    count = sum(key.endswith(" name") for key in arrays)
    return RecordedMotion(
        name,
        tuple(_mat_domain(arrays, number, name) for number in range(count)),
        _header(None if header is None else "".join(header[:1]), name),
        None if columns is None else tuple(map(str, columns)),
    )


def _mat_domain(arrays: Mapping[str, Any], number: int, name: str) -> RecordedDomain:
    """A domain whose samples are columns."""
    fields = {field: arrays[f"{number} {field}"].T for field in FIELDS if f"{number} {field}" in arrays}
    if not {"times", "positions"} <= set(fields):
        raise InputError(f"motion '{printable(name)}': a domain has no states.x")
    return RecordedDomain(**{"name": str(arrays[f"{number} name"]), **fields, "times": np.ravel(fields["times"])})


def _domains(parts: Mapping[str, Mapping[str, Any]], name: str) -> tuple[RecordedDomain, ...]:
    found = []
    for domain, fields in parts.items():
        lacking = {"times", "positions"} - set(fields)
        if lacking:
            raise InputError(f"motion '{printable(name)}': domain '{shown(domain)}' lacks {', '.join(sorted(lacking))}")
        found.append(RecordedDomain(name=domain, **{**fields, "times": np.ravel(fields["times"])}))
    return tuple(found)


def _parsed(cells: Sequence[Sequence[str]], name: str, what: str) -> Any:
    """Numbers of a table, in decimal notation."""
    try:
        return np.array([[parse_number(cell.strip()) for cell in row] for row in cells], dtype=np.float64)
    except ValueError:
        raise InputError(f"motion '{printable(name)}': its {shown(what)} are not all numbers") from None


def _numbers(values: Any, name: str, what: str) -> Any:
    array = np.asarray(values)
    if array.dtype.kind not in "fiu" or array.dtype.itemsize > 8:
        raise InputError(f"motion '{printable(name)}': its {shown(what)} are not all numbers")
    return array.astype(np.float64)


def _header(text: str | None, name: str) -> Json | None:
    if text is None:
        return None
    tree = parse_json(text, f"header of motion '{printable(name)}'")
    if not isinstance(tree, dict):
        raise InputError(f"the header of motion '{printable(name)}' is no gait")
    return tree


FORMATS = {
    ".npz": Format(_write_npz, _read_npz),
    ".csv": Format(_write_csv, _read_csv),
    ".mat": Format(_write_mat, _read_mat),
}
"""Suffix -> format."""
