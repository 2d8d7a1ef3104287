"""Progress of long work on standard error: one live line in a terminal, a plain line now and then elsewhere."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator

from amble.cli.console import say
from amble.cli.output import quiet, wrote
from amble.progress import Progress, ProgressReport, silent

PAUSE = 5.0
"""Seconds between plain lines; the task and the first of them come at once."""


@contextlib.contextmanager
def progress(task: str) -> Iterator[Progress]:
    """Yield a function that shows how far a task is, and tells of the files that it writes."""
    if quiet():
        yield _telling(silent)
        return
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.text import Text  # rows carry names, and rich reads markup into a str

        with Console(stderr=True).status(Text(task)) as status:
            yield _telling(lambda report: status.update(Text(f"{task}: {report}")))
        return
    say(f"{task} ...")
    last = -PAUSE

    def update(report: ProgressReport) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= PAUSE:
            last = now
            say(f"{task}: {report}")

    yield _telling(update)


def _telling(update: Callable[[ProgressReport], None]) -> Progress:
    """Files that were written are results; everything else is progress."""

    def tell(report: ProgressReport) -> None:
        if report.file is None:
            update(report)
        else:
            wrote(report.file)

    return tell
