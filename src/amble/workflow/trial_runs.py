"""Trials of one gait in several engines and processes, resumed where they were left."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from contextlib import ExitStack
from typing import IO

from amble.amounts import check_amount
from amble.errors import WorkError
from amble.progress import Progress, ProgressReport, silent
from amble.stability.robustness import Trial
from amble.workflow.push_trials import TrialFolder, engine_named, pieces, run_trials

MOST_TRIALS, MOST_WORKERS = 10_000_000, 256

WAIT = 0.2
"""Seconds between two looks at the workers."""


def check_trials(trials: int, workers: int) -> None:
    """Refuse numbers of trials and workers that are out of range.

    Raises:
        InputError: in one sentence.
    """
    check_amount("trials", trials, 1, MOST_TRIALS)
    check_amount("workers", workers, 1, MOST_WORKERS)


def do_trials(
    folder: TrialFolder, engines: Sequence[str], trials: int, workers: int = 1, progress: Progress | None = None
) -> dict[str, tuple[Trial, ...]]:
    """Do the trials that are not in the folder yet, and return all of them: engine -> trials.

    Args:
        folder: where they are kept.
        engines: names.
        trials: number of trials in each.
        workers: processes; with one the trials are done in this process.
        progress: called after every piece.

    Raises:
        UnknownNameError: there is no engine of that name.
        InputError: the folder holds other trials, an engine cannot walk the gait, or an amount is out of range.
        WorkError: a worker failed.
    """
    notify = progress or silent
    check_trials(trials, workers)
    makers = {name: engine_named(name) for name in engines}
    folder.claim()
    for name, make in makers.items():
        missing = folder.missing(name, trials)
        if missing and min(workers, len(missing)) == 1:
            run = make(folder.gait, folder.settings)
            for number, piece in enumerate(missing):
                folder.write(name, piece, list(run_trials(folder.gait, folder.settings, run, piece)))
                notify(ProgressReport(what=f"{name}, piece", done=number + 1, of=len(missing)))
        elif missing:
            _by_workers(folder, name, trials, missing, workers, notify)
    return {name: _collected(folder, name, trials) for name in makers}


def _collected(folder: TrialFolder, engine: str, trials: int) -> tuple[Trial, ...]:
    found: list[Trial] = []
    for piece in pieces(trials):
        read = folder.read(engine, piece)
        if read is None:
            raise WorkError(f"the piece '{folder.file(engine, piece)}' is not there; run the command again")
        found += read
    return tuple(found)


def _by_workers(
    folder: TrialFolder, engine: str, trials: int, missing: Sequence[range], workers: int, notify: Progress
) -> None:
    """Start workers, wait for them, and end them where one fails or this process is interrupted."""
    with ExitStack() as stack:
        running: list[tuple[subprocess.Popen[bytes], IO[bytes]]] = []
        for number in range(workers):
            told: IO[bytes] = stack.enter_context(tempfile.TemporaryFile())
            command = [sys.executable, "-m", "amble.workflow.trial_worker", str(folder.place), engine]
            command += [str(trials), str(number), str(workers)]
            process = subprocess.Popen(command, stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=told)
            stack.callback(process.wait)
            stack.callback(process.terminate)
            running.append((process, told))
        codes: list[int | None] = [None]
        while None in codes:
            time.sleep(WAIT)
            codes = [process.poll() for process, _ in running]
            done = sum(os.path.isfile(folder.file(engine, piece)) for piece in missing)
            notify(ProgressReport(what=f"{engine}, piece", done=done, of=len(missing)))
            for code, (_, told) in zip(codes, running, strict=True):
                if code:
                    raise WorkError(f"trials in '{engine}' failed: {_last_line(told)}")


def _last_line(stream: IO[bytes]) -> str:
    stream.seek(0)
    lines = stream.read().decode("utf-8", "replace").strip().splitlines()
    return lines[-1].removeprefix("error: ") if lines else "a worker ended without a word"
