"""Progress of long work on standard error: one live line in a terminal, a plain line now and then elsewhere."""

from __future__ import annotations

import contextlib
import sys
import time
from collections.abc import Callable, Iterator

from amble.cli.console import say

PAUSE = 5.0
"""Seconds between plain lines; the task and the first of them come at once."""

Update = Callable[[str], None]


@contextlib.contextmanager
def progress(task: str) -> Iterator[Update]:
    """Yield a function that shows how far a task is."""
    if sys.stderr.isatty():
        from rich.console import Console
        from rich.text import Text  # rows carry names, and rich reads markup into a str

        with Console(stderr=True).status(Text(task)) as status:
            yield lambda text: status.update(Text(f"{task}: {text}"))
        return
    say(f"{task} ...")
    last = -PAUSE

    def update(text: str) -> None:
        nonlocal last
        now = time.monotonic()
        if now - last >= PAUSE:
            last = now
            say(f"{task}: {text}")

    yield update
