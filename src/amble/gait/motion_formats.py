"""Formats of a motion: npz, CSV, and MATLAB's mat with the fields that FROST has."""

from __future__ import annotations

import csv
import io
import zipfile
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from amble.errors import InputError, printable, shown
from amble.gait.record import Gait
from amble.gait.recorded import FIELDS, HEADER, LARGEST, RecordedDomain, RecordedMotion
from amble.io.reader import parse_json, read_bytes, read_text
from amble.types import Json

FROST = {
    "times": ("tspan",),
    "positions": ("states", "x"),
    "velocities": ("states", "dx"),
    "accelerations": ("states", "ddx"),
}
"""Fields of FROST's gait, one column a sample there; inputs of other programs are not read, since frames differ."""


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
    try:
        with zipfile.ZipFile(io.BytesIO(data)) as archive:
            if sum(entry.file_size for entry in archive.infolist()) > LARGEST:
                raise InputError(f"motion '{printable(name)}' unpacks to more than {LARGEST} bytes")
        with np.load(io.BytesIO(data), allow_pickle=False) as found:
            arrays = {key: np.asarray(found[key]) for key in found.files}
    except (ValueError, OSError, zipfile.BadZipFile, KeyError, EOFError, NotImplementedError) as error:
        raise InputError(f"motion '{printable(name)}' is no npz file: {shown(str(error))}") from None
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
        None if columns is None else tuple(str(column) for column in columns.ravel()),
    )


def _write_csv(gait: Gait, text: str) -> bytes:
    names, feet = gait.robot.coordinate_names, gait.pattern.all_contacts.labels
    head = ["domain", "time", *_columns(names), *(f"torque {j}" for j in gait.robot.joint_names)]
    stream = io.StringIO()
    stream.write(f"# {HEADER} {text}\n")
    writer = csv.writer(stream, lineterminator="\n")
    writer.writerow([*head, *(f"force {label}" for label in feet)])
    for domain in gait.domains:
        places = gait.pattern.contacts(gait.pattern.stance(domain.name)).columns
        for row in range(len(domain.times)):
            forces = [""] * len(feet)
            for place, value in zip(places, domain.forces[row], strict=True):
                forces[place] = repr(float(value))
            numbers = [domain.times[row], *domain.positions[row], *domain.velocities[row], *domain.accelerations[row]]
            values = [repr(float(value)) for value in (*numbers, *domain.torques[row])]
            writer.writerow([domain.name, *values, *forces])
    return stream.getvalue().encode()


def _columns(names: Sequence[str]) -> list[str]:
    return [*names, *(f"rate of {name}" for name in names), *(f"acceleration of {name}" for name in names)]


def _read_csv(path: str | Path) -> RecordedMotion:
    name, text = Path(path).name, read_text(path, "motion", LARGEST)
    header = None
    if text.startswith(f"# {HEADER} "):
        first, _, text = text.partition("\n")
        header = first[len(HEADER) + 3 :]
    rows = csv.reader(io.StringIO(text))
    head = next(rows, [])
    if head[:2] != ["domain", "time"]:
        raise InputError(f"motion '{printable(name)}': its columns begin with domain and time, then the coordinates")
    kinds = {"rate of ": "velocities", "acceleration of ": "accelerations", "torque ": "torques", "force ": "forces"}
    titles = head[2:]
    field_of = [
        next((kind for start, kind in kinds.items() if title.startswith(start)), "positions") for title in titles
    ]
    table: dict[str, list[list[str]]] = {}
    for number, row in enumerate(rows, start=2):
        if len(row) != len(head):
            raise InputError(f"motion '{printable(name)}': row {number} has {len(row)} cells, not {len(head)}")
        table.setdefault(row[0], []).append(row[1:])
    parts: dict[str, dict[str, Any]] = {}
    for domain, lines in table.items():
        fields: dict[str, Any] = {"times": _numbers([line[0] for line in lines], name, "time")}
        for field in dict.fromkeys(field_of):
            chosen = [place for place, kind in enumerate(field_of, start=1) if kind == field]
            kept = [place for place in chosen if field != "forces" or any(line[place] for line in lines)]
            fields[field] = _numbers([[line[place] for place in kept] for line in lines], name, field)
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
    return stream.getvalue()


def _read_mat(path: str | Path) -> RecordedMotion:
    from scipy.io import loadmat
    from scipy.io.matlab import MatReadError

    name, data = Path(path).name, read_bytes(path, "motion", LARGEST)
    try:
        found = loadmat(io.BytesIO(data), squeeze_me=False, struct_as_record=True)
    except (MatReadError, ValueError, TypeError, OSError, NotImplementedError, IndexError, KeyError, EOFError) as error:
        raise InputError(f"motion '{printable(name)}' is no mat file up to version 7: {shown(str(error))}") from None
    gait = found.get("gait")
    if gait is None or gait.dtype.names is None or not {"tspan", "states"} <= set(gait.dtype.names):
        raise InputError(f"motion '{printable(name)}' has no variable gait, a struct with tspan and states.x")
    domains = tuple(_mat_domains(gait, name))
    header = found.get(HEADER)
    columns = found.get("coordinates")
    return RecordedMotion(
        name,
        domains,
        _header(None if header is None else str(header.ravel()[0]), name),
        None if columns is None else tuple(str(np.ravel(column)[0]) for column in columns.ravel()),
    )


def _mat_domains(gait: Any, name: str) -> Iterator[RecordedDomain]:
    """The entries with more than one sample: FROST puts one for every edge between those of the domains."""
    for entry in gait.ravel():
        if np.size(entry["tspan"]) < 2:
            continue
        label = str(np.ravel(entry["name"])[0]) if "name" in gait.dtype.names and np.size(entry["name"]) else ""
        values = {field: _inner(entry, place) for field, place in FROST.items()}
        inputs = entry["inputs"] if "inputs" in gait.dtype.names else None
        amble_wrote = inputs is not None and inputs.dtype.names is not None and {"u", "f"} <= set(inputs.dtype.names)
        for field, key in (("torques", "u"), ("forces", "f")):
            values[field] = _inner(entry, ("inputs", key)) if amble_wrote else None
        read = {field: None if value is None else _numbers(value, name, field) for field, value in values.items()}
        times, positions = read.pop("times"), read.pop("positions")
        if times is None or positions is None:
            raise InputError(f"motion '{printable(name)}': a domain has no states.x")
        rest = {field: None if value is None else value.T for field, value in read.items()}
        yield RecordedDomain(name=label, times=times.ravel(), positions=positions.T, **rest)


def _inner(entry: Any, path: Sequence[str]) -> Any:
    for key in path:
        if entry.dtype.names is None or key not in entry.dtype.names:
            return None
        entry = entry[key]
        if entry.dtype == object and entry.size == 1:
            entry = entry.ravel()[0]
    return entry


def _domains(parts: Mapping[str, Mapping[str, Any]], name: str) -> tuple[RecordedDomain, ...]:
    found = []
    for domain, fields in parts.items():
        lacking = {"times", "positions"} - set(fields)
        if lacking:
            raise InputError(f"motion '{printable(name)}': domain '{shown(domain)}' lacks {', '.join(sorted(lacking))}")
        found.append(RecordedDomain(name=domain, **{**fields, "times": np.ravel(fields["times"])}))
    return tuple(found)


def _numbers(values: Any, name: str, what: str) -> Any:
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(f"motion '{printable(name)}': its {shown(what)} are not all numbers") from None


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
