"""Gaits of real robots by default: solved, checked, stabilised, certified, and walked from changed starts.

Rows are fixed in ``rows``. Each is a process of its own (``fleet_row``) with a limit of processor time, two at a time,
and is written when it is finished. A run goes on where one before ended: what ``fleet.json`` beside the report has from
the same release and the same robot is not computed again. Delete it, or rows of it, to have them computed anew.
"""

from __future__ import annotations

import json
import os
import resource
import subprocess
import sys
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import asdict, replace
from functools import partial
from pathlib import Path
from threading import Lock

import numpy as np

from amble.errors import AmbleError
from amble.io.storage import atomic_write
from benchmarks.figures import Figure, show
from benchmarks.fleet_row import CYCLES, Row, release
from benchmarks.report import FOLDER
from benchmarks.robot_files import FILES

FOUR = ("trot", "amble", "pace", "bound", "walk", "crawl", "running trot")
PRONKING = ("go2", "solo12")
OTHERS = {"bolt": ("walk", "run"), "hexapod": ("tripod",), "planar biped": ("walk", "run")}
QUICK, QUICK_ROBOTS = ("trot", "amble"), ("go2", "a1", "solo12", "anymal_b", "anymal_c", "hyq")
SPEEDS = (0.1, 0.2)
"""Shares of sqrt(g l), l the leg length."""

LIMIT = 300
"""Processor time that a row may take, s; what it reached by then stands in the table."""


def rows(quick: bool = False) -> list[Row]:
    """Return every row of the table, nothing of it computed."""
    if quick:
        names: dict[str, tuple[str, ...]] = dict.fromkeys(QUICK_ROBOTS, QUICK)
    else:
        names = {name: FOUR for name in ("astro", *FILES)} | OTHERS
        names |= {name: (*FOUR, "pronk") for name in PRONKING}
    return [
        Row(robot=name, gait=gait, share=share) for name, gaits in names.items() for gait in gaits for share in SPEEDS
    ]


def in_process(row: Row, folder: Path, whole: bool = True) -> Row:
    """Compute a row in a process of its own; where that ends early, the row is as far as it came.

    Args:
        row: of the table.
        folder: where its gaits are written.
        whole: whether to stabilise, certify and walk what passes its check.
    """
    folder.mkdir(parents=True, exist_ok=True)
    options = [] if whole else ["--checked"]
    command = [sys.executable, "-m", "benchmarks.fleet_row", row.robot, row.gait, f"{row.share:g}", str(folder)]
    ended = subprocess.run(
        [*command, *options],
        capture_output=True,
        text=True,
        env=os.environ | {"OPENBLAS_NUM_THREADS": "1"},
        preexec_fn=partial(resource.setrlimit, resource.RLIMIT_CPU, (LIMIT, LIMIT + 10)),
        check=False,
    )
    told = [Row(**json.loads(line)) for line in ended.stdout.splitlines() if line.startswith("{")]
    last = told[-1] if told else replace(row, status="not begun")
    if ended.returncode > 0:  # no fault of the limit: the last line of the error says what it was
        said = ended.stderr.strip().splitlines()[-1:] or ["no reason"]
        return replace(last, release=last.release or "failed", walk=f"{last.walk} ({said[0]})".strip())
    return replace(last, seconds=float(LIMIT)) if ended.returncode else last


def resumed(asked: Sequence[Row], place: Path, compute: Callable[[Row], Row], workers: int = 1) -> list[Row]:
    """Compute rows that a file does not hold yet; the file is written after every one.

    Args:
        asked: rows of ``rows``.
        place: the file.
        compute: what computes a row.
        workers: how many rows at a time.
    """
    known = [Row(**entry) for entry in json.loads(place.read_text())] if place.exists() else []
    done = {row.key: row for row in known if _current(row)}
    lock = Lock()

    def one(row: Row) -> Row:
        if row.key not in done:
            found = compute(row)
            with lock:
                done[row.key] = found
                atomic_write(place, json.dumps([asdict(entry) for entry in done.values()], indent=1) + "\n")
        print(_line(done[row.key]), flush=True)
        return done[row.key]

    with ThreadPoolExecutor(workers) as pool:
        return list(pool.map(one, asked))


def _current(row: Row) -> bool:
    """Whether a row that was computed before is of this release and this robot."""
    try:
        return row.release == release(row.robot)
    except AmbleError:
        return False


def measure(quick: bool = False) -> list[Figure]:
    """Compute all rows and write their table.

    Args:
        quick: trot and amble of six robots only, without stability.
    """
    name = "fleet-quick" if quick else "fleet"
    compute = partial(in_process, folder=FOLDER / name, whole=not quick)
    found = resumed(rows(quick), FOLDER / f"{name}.json", compute, workers=2)
    atomic_write(FOLDER / f"{name}.md", table(found))
    counts = {what: sum(getattr(row, what) for row in found) for what in ("solved", "passed", "certified", "walked")}
    figures = [
        Figure("gaits of the fleet solved", float(counts["solved"]), "", note=f"of {len(found)}"),
        Figure("of these pass their check", float(counts["passed"]), "", note=f"of {counts['solved']}"),
    ]
    if not quick:
        figures += [
            Figure("of these certified", float(counts["certified"]), "", note=f"of {counts['passed']}"),
            Figure(
                f"of these walk {CYCLES} cycles soundly", float(counts["walked"]), "", note=f"of {counts['certified']}"
            ),
        ]
    seconds = float(np.median([row.seconds for row in found]))
    return [*figures, Figure("processor time a gait", seconds, "s", note="median, all of it")]


def table(found: Sequence[Row]) -> str:
    """Return rows as a Markdown table."""
    header = "| robot | gait | m/s | solver | iterations | check | radius | walk | s |\n|" + "---|" * 9
    return "\n".join([header, *map(_line, found)]) + "\n"


def _line(row: Row) -> str:
    check = "" if not row.solved else f"passes, {row.check}" if row.passed else f"fails: {row.check}"
    cells = (row.robot, row.gait, f"{row.speed:g}", row.status, str(row.iterations or ""), check)
    return f"| {' | '.join((*cells, row.stability, row.walk, f'{row.seconds:.0f}'))} |"


def main(quick: bool = False) -> None:
    """Print what is measured."""
    show(measure(quick))


if __name__ == "__main__":
    main()
