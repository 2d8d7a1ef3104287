"""Workers from outside: each has one input at a time, and is replaced where it hangs or dies."""

from __future__ import annotations

import multiprocessing
import queue
import sys
import threading
import time
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

from fuzz.oracle import Verdict
from fuzz.worker import seconds_of, work

WAITING = 8
"""Longest wait for an answer, as a multiple of the processor time: the machine may be busy, and children work too."""


TELLING = 60.0
"""Seconds between two lines of a run about how far it is."""


class Worker:
    """One process; a hang or a death is a verdict."""

    def __init__(self, cache: str) -> None:
        self._cache = cache
        self._start()

    def _start(self) -> None:
        context = multiprocessing.get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(target=work, args=(theirs, self._cache), daemon=True)
        self._process.start()
        theirs.close()

    def ask(self, kind: str, seed: int, content: bytes | None = None) -> Verdict:
        """Have one input read."""
        try:
            self._connection.send((kind, seed, content))
            if self._connection.poll(WAITING * seconds_of(kind)):
                found: Verdict = self._connection.recv()
                return found
            reason = f"no answer in {WAITING * seconds_of(kind)} s"
        except (EOFError, OSError):
            self._process.join(5)
            reason = f"the process ended with {self._process.exitcode} (-27: {seconds_of(kind)} s of processor time)"
        self.stop()
        self._start()
        return Verdict("failed", reason, f"hang or death: {reason}")

    def stop(self) -> None:
        """End the process."""
        self._connection.close()
        self._process.kill()
        self._process.join()


@dataclass
class Tally:
    """What became of the inputs of a run.

    Attributes:
        counts: outcome -> how many.
        reasons: what was said of those that loaded -> how many.
        failures: signature -> (kind, seed, verdict) of the first input that failed in this way.
    """

    counts: Counter[str] = field(default_factory=Counter)
    reasons: Counter[str] = field(default_factory=Counter)
    failures: dict[str, tuple[str, int, Verdict]] = field(default_factory=dict)


def run(requests: Iterable[tuple[str, int]], workers: int, seconds: float, cache: str, loaded: int = 0) -> Tally:
    """Ask for inputs until there are no more, the time is over, or as many as wanted have loaded.

    Args:
        requests: (kind, seed), may be endless.
        workers: how many processes.
        seconds: wall time.
        cache: folder of compiled code.
        loaded: how many inputs must load; 0 for no such end.
    """
    tally, lock, end = Tally(), threading.Lock(), time.monotonic() + seconds
    source, errors = iter(requests), queue.Queue[BaseException]()

    def loop() -> None:
        worker = Worker(cache)
        try:
            while time.monotonic() < end and not (loaded and tally.counts["loaded"] >= loaded):
                with lock:
                    request: Any = next(source, None)
                if request is None:
                    return
                verdict = worker.ask(*request)
                with lock:
                    tally.counts[verdict.outcome] += 1
                    if verdict.outcome == "loaded":
                        tally.reasons[verdict.reason] += 1
                    if verdict.outcome == "failed":
                        print(f"failed: {request[0]} {request[1]}: {verdict.signature}", file=sys.stderr, flush=True)
                        tally.failures.setdefault(verdict.signature, (*request, verdict))
        except BaseException as error:
            errors.put(error)
        finally:
            worker.stop()

    threads = [threading.Thread(target=loop) for _ in range(workers)]
    for thread in threads:
        thread.start()
    _wait(threads, tally)
    if not errors.empty():
        raise errors.get()
    return tally


def _wait(threads: Sequence[threading.Thread], tally: Tally) -> None:
    """Wait for all threads, and say now and then how far they are."""
    told = time.monotonic()
    for thread in threads:
        while thread.is_alive():
            thread.join(0.5)
            if time.monotonic() - told > TELLING:
                told = time.monotonic()
                print(f"... {dict(tally.counts)}, {len(tally.failures)} kinds of failure", file=sys.stderr, flush=True)
