"""The folder of a library: every gait a file of its own, an index of all numbers, a table of what failed.

A gait is there once its record is: gait and certificate are written before it, each in one step. So whatever stops a
run, the folder holds whole gaits, and the next run goes on with the rest.

    library.json                  the specification without its axes
    gaits/LABEL.json              gaits, as `amble` writes them
    certificates/LABEL.json       their certificates
    failed/LABEL.json             gaits that were solved but fail their check, or are not stable
    records/LABEL.json            what became of every gait, with its numbers
    index.csv, failures.csv       the same as tables
"""

from __future__ import annotations

import json
import os
import re
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass, field
from math import isfinite
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter

from amble.errors import InputError, listed, shown, shown_path
from amble.gait import Gait
from amble.gait.files import content_hash, load_gait, save_gait
from amble.io.reader import read_json, read_record
from amble.io.storage import atomic_write, check_folder, confined, dumps, file_at, folder_at
from amble.io.table import table_text
from amble.report import write_results
from amble.stability.gait_certificate import certificate_to_dict
from amble.types import Json
from amble.version import __version__
from amble.workflow.library.axes import UNITS, LibrarySpecification, label
from amble.workflow.library.entry import STAGES, Made

FORMAT, FORMAT_VERSION = "amble library", 1
HEADER = "library.json"
GAITS, CERTIFICATES, FAILED, RECORDS = "gaits", "certificates", "failed", "records"
LOCKS = "chains"
"""Folder of the locks of single chains, and of what their tasks say on a cluster."""

INDEX, FAILURES = "index.csv", "failures.csv"


Scalar = float | int | str | bool | None
"""What the index of a library holds in a cell."""


@dataclass(frozen=True, kw_only=True)
class LibraryEntry:
    """What became of one gait of a library.

    Attributes:
        values: axis -> its value, in the units of ``UNITS``.
        certified: whether the gait is there, checked, stable and certified.
        stage: the last that was reached: solve, check, stabilise, certify.
        reason: why it failed; empty where it is certified.
        file: the gait's file in the library's folder; None where it was not solved.
        start: label of the neighbour that the solver started from; None of a kinematic walk.
        hash: of the gait's content (``gait.files.content_hash``), as in its certificate; None where it was not solved.
        numbers: everything that was computed: cost of transport, torques, heights, radius, bound, ...
        seconds: stage -> processor time, s.
        notes: warnings on the way.
    """

    values: Mapping[str, float]
    certified: bool
    stage: str
    reason: str
    file: str | None
    start: str | None
    hash: str | None = None
    numbers: Mapping[str, Scalar] = field(default_factory=dict)
    seconds: Mapping[str, float] = field(default_factory=dict)
    notes: tuple[str, ...] = ()

    @property
    def label(self) -> str:
        """Name of its files."""
        return label(self.values)


ENTRY, KEY = TypeAdapter(LibraryEntry), re.compile(r"[A-Za-z0-9_]{1,60}")
"""What a record holds, and the names of its numbers, which also name files of maps."""


@dataclass(frozen=True)
class Library:
    """A folder of gaits over axes.

    Attributes:
        folder: where it is.
        entries: all gaits that were tried, in the order of their labels.
    """

    folder: Path
    entries: tuple[LibraryEntry, ...]

    @property
    def certified(self) -> tuple[LibraryEntry, ...]:
        """The gaits that can be walked."""
        return tuple(entry for entry in self.entries if entry.certified)

    @property
    def failures(self) -> tuple[LibraryEntry, ...]:
        """What failed."""
        return tuple(entry for entry in self.entries if not entry.certified)

    def gait(self, entry: LibraryEntry) -> Gait:
        """Load the gait of an entry.

        Raises:
            InputError: it was not solved, its file cannot be read, or record or certificate are of another content.
        """
        if entry.file is None:
            raise InputError(f"there is no gait at {entry.label}: {shown(entry.reason, 1000)}")
        gait = load_gait(self.folder / entry.file)
        told = {"record": entry.hash}
        if entry.certified:
            of = read_json(self.folder / CERTIFICATES / f"{entry.label}.json", "certificate").get("gait")
            told["certificate"] = of.get("content_hash") if isinstance(of, dict) else None
        for what, known in told.items():
            if known != content_hash(gait):
                raise InputError(
                    f"'{shown_path(self.folder / entry.file)}' is not the gait that its {what} tells of: it was "
                    f"changed after it was made; remove {RECORDS}/{entry.label}.json, and `amble library` makes it anew"
                )
        return gait


def load_library(folder: str | Path) -> Library:
    """Read a library, also one that is still being built.

    Raises:
        InputError: there is none, or a record cannot be read.
    """
    place = Path(folder)
    tree = read_json(place / HEADER, "library")
    if tree.get("format") != FORMAT or tree.get("format_version") != FORMAT_VERSION:
        raise InputError(f"'{shown_path(place / HEADER)}' is no library of format version {FORMAT_VERSION}")
    records = sorted((place / RECORDS).glob("*.json"))
    return Library(place, tuple(_entry(path) for path in records))


def claim_folder(folder: Path, library: LibrarySpecification) -> None:
    """Make the folder of a library, or refuse one that another specification made.

    The axes may differ: what is there of them is kept.

    Raises:
        InputError: the folder holds something else.
    """
    tree = {
        "format": FORMAT,
        "format_version": FORMAT_VERSION,
        "amble": __version__,
        "axes": {name: UNITS[name] for name in sorted(library.grid.names)},
        "specification": json.loads(json.dumps(library.tree, default=str)),
    }
    path = folder / HEADER
    folder_at(folder)
    with confined(folder):  # what cannot be written is known before the work
        for name in (GAITS, CERTIFICATES, FAILED, RECORDS, LOCKS):
            folder_at(folder / name)
        for name in (HEADER, INDEX, FAILURES):
            file_at(folder / name)
    if os.path.lexists(path):
        known = read_json(path, "library")
        parts = ("format", "format_version", "axes", "specification")
        if any(known.get(part) != tree[part] for part in parts):
            raise InputError(
                f"'{shown_path(folder)}' holds the library of another specification (its {HEADER}); name another "
                "folder, or remove it"
            )
        return
    check_folder(folder)
    if os.path.isdir(folder) and os.listdir(folder):
        raise InputError(f"'{shown_path(folder)}' holds files that are no library; name another folder")
    with confined(folder):
        atomic_write(path, dumps(tree) + "\n")


def write_entry(folder: Path, values: Mapping[str, float], start: str | None, made: Made) -> LibraryEntry:
    """Write what became of one gait; its record is the last file."""
    with confined(folder):
        certified = made.certificate is not None and not made.reason
        name, file = label(values), None
        if made.gait is not None:
            file = f"{GAITS if certified else FAILED}/{name}.json"
            save_gait(made.gait, folder / file)
            other = folder_at(folder / (FAILED if certified else GAITS))
            (other / f"{name}.json").unlink(missing_ok=True)
        if made.gait is not None and made.certificate is not None and certified:
            write_results(folder / CERTIFICATES / f"{name}.json", certificate_to_dict(made.gait, made.certificate))
        entry = LibraryEntry(
            values=dict(values),
            certified=certified,
            stage=made.stage,
            reason=made.reason,
            file=file,
            start=start,
            hash=None if made.gait is None else content_hash(made.gait),
            numbers=made.numbers,
            seconds=made.seconds,
            notes=tuple(made.notes),
        )
        atomic_write(record_of(folder, values), dumps({**asdict(entry), "notes": list(entry.notes)}) + "\n")
    return entry


def record_of(folder: Path, values: Mapping[str, float]) -> Path:
    """Return the place of a record."""
    return folder / RECORDS / f"{label(values)}.json"


def read_entry(folder: Path, values: Mapping[str, float]) -> LibraryEntry | None:
    """Read what became of one gait; None where nothing has yet."""
    path = record_of(folder, values)
    return _entry(path) if os.path.lexists(path) else None


def _entry(path: Path) -> LibraryEntry:
    """Read a record as strictly as a file from elsewhere: what it says is there has to be there.

    Raises:
        InputError: it is no record, or of another gait, or says certified without a gait and a certificate.
    """
    entry, folder = read_record(path, "record of a library", ENTRY), path.parent.parent
    what = f"'{shown_path(path)}' is no record of a library"
    numbers = [*entry.values.values(), *entry.seconds.values(), *_floats(entry.numbers)]
    if entry.stage not in STAGES:
        raise InputError(f"{what}: '{shown(entry.stage)}' is no stage")
    if not set(entry.values) <= set(UNITS) or not all(map(isfinite, numbers)):
        raise InputError(f"{what}: an axis is unknown, or a number not finite")
    if not all(KEY.fullmatch(key) for key in (*entry.numbers, *entry.seconds)):
        raise InputError(f"{what}: a name in it is none")
    name = f"{path.stem}.json"
    own = f"{GAITS if entry.certified else FAILED}/{name}"
    needed = [own, f"{CERTIFICATES}/{name}"] if entry.certified else [own] if entry.file else []
    lacking = [file for file in needed if not os.path.isfile(folder / file)]
    if (entry.hash is None) != (entry.file is None):
        raise InputError(f"{what}: it says nothing of the content of its gait, or of one that is not there")
    if entry.label != path.stem or entry.file != (own if needed else None) or lacking:
        raise InputError(f"{what}: it is of another gait, or {listed(lacking) or own} is not there")
    return entry


def _floats(numbers: Mapping[str, Any]) -> list[float]:
    return [value for value in numbers.values() if isinstance(value, float | int)]


def write_tables(library: Library) -> tuple[Path, Path]:
    """Write the index of all gaits and the table of what failed."""
    with confined(library.folder):
        return (
            _table(library.folder / INDEX, library.certified, reasons=False),
            _table(library.folder / FAILURES, library.failures, reasons=True),
        )


def _table(path: Path, entries: Iterable[LibraryEntry], reasons: bool) -> Path:
    rows = [_row(entry, reasons) for entry in entries]
    columns = list(dict.fromkeys(key for row in rows for key in row))
    return atomic_write(path, table_text([columns, *([row.get(key) for key in columns] for row in rows)]))


def _row(entry: LibraryEntry, reasons: bool) -> Json:
    axes = {name if UNITS[name] == "1" else f"{name} ({UNITS[name]})": entry.values[name] for name in entry.values}
    why = {"stage": entry.stage, "reason": " ".join(entry.reason.split())} if reasons else {}
    spent = {f"{stage}_processor_s": round(seconds, 3) for stage, seconds in entry.seconds.items()}
    return {**axes, **why, **entry.numbers, **spent, "start": entry.start, "file": entry.file}
