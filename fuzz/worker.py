"""A process that reads one input after the other, with bounds on processor time and memory.

A hang ends it by a signal; whoever asked sees that and starts another.
"""

from __future__ import annotations

import os
import resource
import signal
import sys
import tempfile
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

from fuzz import oracle, walkers
from fuzz.kinds import drawn
from fuzz.oracle import Verdict, judged
from fuzz.registry import BY_NAME

WALKER = "walker"
"""Name of the kind of input that goes through check, certificate and export."""


def content_of(kind: str, seed: int) -> tuple[bytes, list[str]]:
    """Return the input of a kind and a seed, and what was done to it."""
    if kind == WALKER:
        import random

        return walkers.draw_walker(random.Random(f"{kind} {seed}"))
    return drawn(BY_NAME[kind], seed)


def suffix_of(kind: str) -> str:
    """Return how files of a kind end."""
    return ".json" if kind == WALKER else BY_NAME[kind].suffix


def seconds_of(kind: str) -> int:
    """Return the processor time that an input of a kind may take."""
    return walkers.SECONDS if kind == WALKER else oracle.SECONDS


def verdict_of(kind: str, content: bytes, folder: Path) -> Verdict:
    """Read one input."""
    path = folder / f"input{suffix_of(kind)}"
    path.write_bytes(content)
    return walkers.walk(path, folder) if kind == WALKER else judged(BY_NAME[kind].read, path)


def work(connection: Connection, cache: str) -> None:
    """Answer requests (kind, seed, content or None) with verdicts until there are no more."""
    os.environ["AMBLE_CACHE"] = cache
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    resource.setrlimit(resource.RLIMIT_DATA, (oracle.MEMORY, oracle.MEMORY))
    with tempfile.TemporaryDirectory() as folder, tempfile.TemporaryFile() as said:
        os.dup2(said.fileno(), sys.stdout.fileno())
        os.dup2(said.fileno(), sys.stderr.fileno())
        while True:
            try:
                request = connection.recv()
            except EOFError:
                return
            connection.send(_answer(request, Path(folder), said))


def _answer(request: tuple[str, int, bytes | None], folder: Path, said: Any) -> Verdict:
    kind, seed, content = request
    if content is None:
        content = content_of(kind, seed)[0]
    signal.setitimer(signal.ITIMER_PROF, seconds_of(kind))  # its signal ends the process
    verdict = verdict_of(kind, content, folder)
    signal.setitimer(signal.ITIMER_PROF, 0)
    sys.stdout.flush()
    sys.stderr.flush()
    said.seek(0)
    text = said.read().decode("utf-8", "replace")
    said.seek(0)
    said.truncate()
    if text.strip() and verdict.outcome != "failed":
        return Verdict("failed", text[:5000], "something is printed")
    return verdict
