"""Building a library: the way through the grid, gait by gait, by processes on this machine."""

from __future__ import annotations

import contextlib
import os
import sys
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Literal

from amble.amounts import check_amount
from amble.errors import InputError, shown_path
from amble.io.storage import confined, folder_at
from amble.progress import Progress, ProgressReport, silent
from amble.types import Json
from amble.workflow.library.axes import LibrarySpecification, check_ends, label, read_library
from amble.workflow.library.cluster import run_on_cluster
from amble.workflow.library.entry import STAGES, Made
from amble.workflow.library.files import HEADER, LOCKS, Library, claim_folder, load_library, write_entry, write_tables
from amble.workflow.library.grid import Point
from amble.workflow.library.maps import write_maps
from amble.workflow.library.pool import Work, run_pool
from amble.workflow.library.way import Way

try:
    import fcntl
except ImportError:  # a system without advisory locks
    fcntl = None  # type: ignore[assignment]

MOST_WORKERS = 256
"""Processes on one machine."""


def build_library(
    specification: str | Path,
    out: str | Path,
    *,
    workers: int | Literal["hyperqueue"] = 1,
    again: bool = False,
    plugins: Sequence[str] = (),
    progress: Progress | None = None,
    chain: int | None = None,
) -> Library:
    """Find the gaits of a specification with axes, each checked, stabilised and certified, in a folder.

    Every gait starts from its neighbour on the way through the grid (``grid.Grid``) and keeps that one's output weights
    where they serve. A folder that was begun is completed: what is there, gaits and failures, is not done again. Which
    gait starts from which does not depend on the number of workers or on interruptions.

    Args:
        specification: a specification file with a table ``[library]``.
        out: the folder.
        workers: how many processes on this machine; or "hyperqueue": the server of a cluster runs the chains of
            neighbours (``cluster``).
        again: try again what failed.
        plugins: modules, or Python files, that every process imports first.
        progress: called with what is being done, and with the files that were written.
        chain: make the gaits of one chain of neighbours only, by its number; tables and maps are then left to another.

    Raises:
        InputError: the specification, the folder or a number cannot be used, or another run is at work in the folder.
        WorkError: the processes cannot be started.
    """
    if workers != "hyperqueue":
        check_amount("workers", workers, 1, MOST_WORKERS)
    notify, folder = progress or silent, Path(out)
    library = read_library(specification)
    check_ends(library)
    claim_folder(folder, library)
    heads = chains(library)
    if chain is not None and not 0 <= chain < len(heads):
        raise InputError(f"there is no chain {chain}; the library has chains 0 to {len(heads) - 1}")
    with _alone(folder, shared=chain is not None or workers == "hyperqueue"), _one_of(folder, chain):
        if workers == "hyperqueue" and chain is None:
            run_on_cluster(library, heads, Path(specification), folder, plugins, again, notify)
        else:
            way = Way(folder, library.grid, again, None if chain is None else heads[chain])
            worker = [sys.executable, "-m", "amble.workflow.library.worker", str(os.getpid())]
            command = [*worker, str(specification), str(folder), *plugins]
            _make(library, folder, way, command, 1 if workers == "hyperqueue" else workers, notify)
        return finish(folder, notify) if chain is None else load_library(folder)


def finish(folder: Path, notify: Progress) -> Library:
    """Write tables and maps of what is there."""
    found = load_library(folder)
    for path in (*write_tables(found), *write_maps(found)):
        notify(ProgressReport(what="wrote", file=path))
    return found


def chains(library: LibrarySpecification) -> tuple[Point, ...]:
    """Return the first points of all chains of neighbours, those that others begin from first."""
    return tuple(dict.fromkeys(library.grid.chain(point) for point in library.grid.points()))


def _make(
    library: LibrarySpecification, folder: Path, way: Way, command: Sequence[str], workers: int, notify: Progress
) -> None:
    values = library.grid.at

    def say(point: Point, stage: str) -> None:
        failed = f", {way.failed} failed" if way.failed else ""
        notify(
            ProgressReport(
                what="gaits", done=way.settled, of=way.size, detail=f"{label(values(point))}: {stage}{failed}"
            )
        )

    def task(point: Point) -> Json:
        return way.task(point).to_dict()

    def done(point: Point) -> None:
        way.read(point)
        say(point, "done")

    def lost(point: Point, stage: str, reason: str) -> None:
        start = way.task(point).start
        made = Made(stage=stage if stage in STAGES else STAGES[0], reason=reason)
        way.settle(point, write_entry(folder, values(point), None if start is None else Path(start).stem, made))
        say(point, reason)

    run_pool(command, workers, library.time_limit, Work(next=way.next, task=task, done=done, lost=lost, tell=say))


@contextlib.contextmanager
def _one_of(folder: Path, chain: int | None) -> Iterator[None]:
    """Let one process at a time make a chain: one whose worker was lost may still be at it."""
    if fcntl is None or chain is None:
        yield
        return
    place = folder / LOCKS / f"{chain}.lock"
    try:
        with confined(folder):
            folder_at(place.parent).mkdir(exist_ok=True)
        lock = os.open(place, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC | os.O_NOFOLLOW, 0o644)
    except OSError as error:
        raise InputError(f"cannot lock '{shown_path(place)}': {error.strerror or error}") from None
    try:
        with contextlib.suppress(OSError):  # a file system without locks
            fcntl.flock(lock, fcntl.LOCK_EX)
        yield
    finally:
        os.close(lock)


@contextlib.contextmanager
def _alone(folder: Path, shared: bool) -> Iterator[None]:
    """Keep another run out of the folder; runs of single chains share it. The system ends the lock with the process."""
    if fcntl is None:
        yield
        return
    lock = os.open(folder / HEADER, os.O_RDONLY | os.O_CLOEXEC)
    try:
        try:
            fcntl.flock(lock, (fcntl.LOCK_SH if shared else fcntl.LOCK_EX) | fcntl.LOCK_NB)
        except BlockingIOError:
            raise InputError(f"another run is at work in '{shown_path(folder)}'") from None
        except OSError:  # a file system without locks
            pass
        yield
    finally:
        os.close(lock)
