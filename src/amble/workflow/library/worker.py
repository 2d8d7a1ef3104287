"""A process that makes gaits of a library, one after the other; what one structure needs is built once in it.

It says that it is ready, reads one task a line on standard input and answers with one line on standard output when the
gait's record is written. It ends when its input does, and with the process that started it. Whatever a gait does to it,
that gait alone is lost: nothing is kept here that the files do not hold.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
import json
import os
import signal
import sys
from pathlib import Path

from amble.gait import Gait
from amble.gait.files import load_gait
from amble.io.plugins import load_plugins
from amble.progress import Progress, ProgressReport, silent
from amble.workflow.library.axes import LibrarySpecification, read_library
from amble.workflow.library.entry import STAGES, make_gait
from amble.workflow.library.files import LibraryEntry, write_entry
from amble.workflow.library.way import Task

_DEATH = 1
"""PR_SET_PDEATHSIG of prctl."""


def main() -> None:
    """Serve the tasks of one library: arguments are who started it, its specification, its folder and plugins."""
    starter, specification, folder, *plugins = sys.argv[1:]
    end_with(int(starter))
    answers = os.fdopen(os.dup(1), "w", encoding="utf-8")
    os.dup2(2, 1)  # what others print is no answer
    load_plugins(plugins)
    library = read_library(specification)

    stage = STAGES[0]

    def tell(report: ProgressReport) -> None:
        nonlocal stage
        stage = report.what if report.what in STAGES else stage
        print(json.dumps({"stage": stage, "at": str(report)}), file=answers, flush=True)

    print(json.dumps({"ready": True}), file=answers, flush=True)
    for line in sys.stdin:
        entry = serve(library, Path(folder), Task(**json.loads(line)), tell)
        print(json.dumps({"done": entry.label}), file=answers, flush=True)


def serve(library: LibrarySpecification, folder: Path, task: Task, progress: Progress = silent) -> LibraryEntry:
    """Make one gait and write it."""
    near = None if task.start is None else _loaded(folder / task.start)
    stable = None if task.weights is None else _loaded(folder / task.weights)
    made = make_gait(library, task.values, near, stable, progress)
    return write_entry(folder, task.values, None if task.start is None else Path(task.start).stem, made)


@functools.lru_cache(maxsize=2)
def _loaded(path: Path) -> Gait:
    return load_gait(path)


def end_with(starter: int) -> None:
    """Let the system end this process with the one that started it, where it can (Linux); at once if that is gone."""
    if sys.platform == "linux":
        with contextlib.suppress(OSError, AttributeError):
            ctypes.CDLL(None).prctl(_DEATH, signal.SIGKILL)
    if os.getppid() != starter:  # it ended while this process imported what it needs
        raise SystemExit(1)


if __name__ == "__main__":
    main()
