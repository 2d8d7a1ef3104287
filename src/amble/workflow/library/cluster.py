"""A library on a cluster: chains of neighbours as tasks of HyperQueue, which runs them over Slurm or PBS allocations.

A task is ``amble library SPEC --out DIR --chain N``: it makes what of its chain is not there yet, so HyperQueue may run
it again after a worker is lost. A chain waits for the one that holds the gait which it begins from.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from amble.errors import InputError, WorkError, shown
from amble.io.storage import confined, folder_at
from amble.optional import require
from amble.progress import Progress, ProgressReport
from amble.workflow.library.axes import LibrarySpecification
from amble.workflow.library.files import LOCKS
from amble.workflow.library.grid import Point
from amble.workflow.library.way import Way

SERVER = "HQ_SERVER_DIR"
"""Variable of the environment with the folder in which HyperQueue's server leaves how it is reached."""

CRASHES = 20
"""How many workers may be lost under one chain; what a gait does to a process is no crash of a worker."""


def run_on_cluster(
    library: LibrarySpecification,
    heads: Sequence[Point],
    specification: Path,
    folder: Path,
    plugins: Sequence[str],
    again: bool,
    notify: Progress,
) -> None:
    """Submit all chains that are not complete to the server that is running, and wait until they are.

    Args:
        library: the library.
        heads: first points of its chains.
        specification: its file, which every node of the cluster can read.
        folder: of the library, which every node can write.
        plugins: modules that every process imports first.
        again: whether what failed is tried again.
        notify: called after every chain.

    Raises:
        MissingExtraError: HyperQueue is not installed.
        InputError: no server is running.
        WorkError: chains could not be run.
    """
    require("hyperqueue", "cluster", "libraries on a cluster")
    from hyperqueue import Client, Job

    try:
        client = Client(os.environ.get(SERVER))
    except Exception as error:  # whatever the library raises
        raise InputError(
            f"no HyperQueue server can be reached: start one (hq server start), or name its folder in {SERVER} "
            f"({shown(str(error), 200)})"
        ) from None
    with confined(folder):
        folder_at(folder / LOCKS).mkdir(exist_ok=True)
    job = Job(max_fails=None, default_workdir=Path.cwd(), name="amble library")
    tasks: dict[Point, Any] = {}
    for number, head in enumerate(heads):
        way = Way(folder, library.grid, again, head)
        if way.settled == way.size:
            continue
        parent = library.grid.parent(head)
        before = None if parent is None else tasks.get(library.grid.chain(parent))
        options = ["--again"] if again else []
        tasks[head] = job.program(
            [
                *(sys.executable, "-m", "amble", "library", str(specification.resolve())),
                *("--out", str(folder.resolve()), "--chain", str(number), "--quiet", *options),
                *(part for plugin in plugins for part in ("--plugin", plugin)),
            ],
            deps=[] if before is None else [before],
            stdout=None,
            stderr=str((folder / LOCKS / f"{number}.stderr").resolve()),
            name=f"chain {number}",
            crash_limit=CRASHES,
        )
    if tasks:
        _wait(client, client.submit(job), len(tasks), notify)


def _wait(client: Any, submitted: Any, count: int, notify: Progress) -> None:
    """Wait for a job; what of it could not be run is a failure of the work, not of gaits."""

    def tell(jobs: Any) -> None:
        finished = sum(state["finished"] for state in jobs.values())
        notify(ProgressReport(what="chains", done=int(finished), of=count))

    client.connection.wait_for_jobs((submitted.id,), tell)
    failed = client.get_failed_tasks(submitted)
    if failed:
        first = next(iter(failed.values()))
        raise WorkError(f"{len(failed)} of {count} chains could not be run: {shown(first.error, 300)}")
