"""Processes that make the gaits of a library: one that hangs or ends costs the gait that it is at, and no other."""

from __future__ import annotations

import json
import os
import selectors
import signal
import subprocess
import tempfile
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import IO, Any

from amble.errors import WorkError, shown
from amble.types import Json
from amble.workflow.library.grid import Point

TAIL = 4096
"""Bytes of a process's last words that are looked at."""

PATIENCE = 600.0
"""Seconds in which a process has to be ready: its imports, on a busy machine."""


@dataclass
class Worker:
    """A process with the gait that it is at.

    Attributes:
        process: it.
        words: its standard error, a file.
        point: the gait; None while it waits for one.
        deadline: when the gait has to be done, by ``time.monotonic``.
        stage: what it said last of the gait.
        ready: whether it has ever answered.
        read: bytes of an answer that is not whole yet.
    """

    process: subprocess.Popen[bytes]
    words: IO[bytes]
    point: Point | None = None
    deadline: float = field(default=0.0)
    stage: str = ""
    ready: bool = False
    read: bytes = b""

    @classmethod
    def started(cls, command: Sequence[str]) -> Worker:
        """Start a process, in a session of its own: Ctrl-C is for the one that started it."""
        words = tempfile.TemporaryFile()  # noqa: SIM115
        process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=words, start_new_session=True
        )
        return cls(process, words, deadline=time.monotonic() + PATIENCE)

    def begin(self, point: Point, task: Json, time_limit: float) -> None:
        """Hand a task over."""
        self.point, self.stage, self.deadline = point, "", time.monotonic() + time_limit
        self._stdin.write(json.dumps(task).encode() + b"\n")
        self._stdin.flush()

    def answers(self) -> list[Json] | None:
        """Return the answers that have arrived; None where the process has ended."""
        data = os.read(self.output.fileno(), 1 << 16)
        if not data:
            return None
        *lines, self.read = (self.read + data).split(b"\n")
        return [json.loads(line) for line in lines]

    @property
    def output(self) -> IO[bytes]:
        """Its standard output."""
        return _there(self.process.stdout)

    @property
    def _stdin(self) -> IO[bytes]:
        return _there(self.process.stdin)

    def end(self) -> int:
        """End the process, however it is, and return its exit code."""
        if self.process.poll() is None:
            self.process.kill()
        code = self.process.wait()
        for stream in (self._stdin, self.output):
            try:
                stream.close()
            except OSError:  # a task that was never read
                continue
        return code

    def last_words(self, code: int) -> str:
        """Say in one sentence how a process ended that nobody asked to."""
        self.words.seek(max(self.words.seek(0, os.SEEK_END) - TAIL, 0))
        lines = self.words.read().decode(errors="replace").split("\n")
        said = next((line.strip() for line in reversed(lines) if line.strip()), "")
        how = f"by signal {signal.Signals(-code).name}" if code < 0 else f"with exit code {code}"
        return f"its process ended {how}" + (f": {shown(said, 300)}" if said else "")


@dataclass(frozen=True, kw_only=True)
class Work:
    """What a pool asks of whoever runs it.

    Attributes:
        next: takes the next gait; None where none can be begun now.
        task: what a process has to know of a gait.
        done: a gait's record is written.
        lost: a gait has none: it took too long, or its process ended; with the stage and the reason.
        tell: a gait is at a stage.
    """

    next: Callable[[], Point | None]
    task: Callable[[Point], Json]
    done: Callable[[Point], None]
    lost: Callable[[Point, str, str], None]
    tell: Callable[[Point, str], None]


def run_pool(command: Sequence[str], count: int, time_limit: float, work: Work) -> None:
    """Make gaits in processes until none is left that can be begun.

    Args:
        command: starts a process.
        count: how many at a time.
        time_limit: wall time after which a gait is given up, s.
        work: the gaits.

    Raises:
        WorkError: a process ends before it is ready: no gait is to blame.
    """
    workers: list[Worker] = []
    with selectors.DefaultSelector() as selector:
        try:
            while True:
                _hand_out(workers, selector, command, count, time_limit, work)
                busy = [worker for worker in workers if worker.point is not None]
                if not busy:
                    return
                wait = max(min(worker.deadline for worker in busy) - time.monotonic(), 0.0)
                for key, _ in selector.select(wait):
                    _heard(key.data, workers, selector, work)
                for worker in [each for each in workers if each.point and time.monotonic() > each.deadline]:
                    _given_up(worker, workers, selector, f"it took more than {time_limit:g} s", work)
        finally:
            for worker in workers:
                worker.end()


def _hand_out(
    workers: list[Worker],
    selector: selectors.BaseSelector,
    command: Sequence[str],
    count: int,
    time_limit: float,
    work: Work,
) -> None:
    """Give every process that waits a gait; start as many as there are gaits."""
    while True:
        idle = next((worker for worker in workers if worker.point is None), None)
        if idle is None and len(workers) >= count:
            return
        point = work.next()
        if point is None:
            return
        if idle is None:
            idle = Worker.started(command)
            workers.append(idle)
            selector.register(idle.output, selectors.EVENT_READ, idle)
        try:
            idle.begin(point, work.task(point), time_limit if idle.ready else time_limit + PATIENCE)
        except BrokenPipeError:
            raise WorkError(f"a worker cannot be used: {idle.last_words(idle.end())}") from None


def _heard(worker: Worker, workers: list[Worker], selector: selectors.BaseSelector, work: Work) -> None:
    answers = worker.answers()
    if answers is None:
        code = worker.end()
        if not worker.ready:
            raise WorkError(f"a worker cannot be used: {worker.last_words(code)}")
        _given_up(worker, workers, selector, worker.last_words(code), work)
        return
    for answer in answers:
        point, worker.ready = worker.point, True
        if point is not None and "done" in answer:
            worker.point = None
            work.done(point)
        elif point is not None:
            worker.stage = worker.stage if "at" not in answer else str(answer["at"])
            work.tell(point, worker.stage)


def _given_up(worker: Worker, workers: list[Worker], selector: selectors.BaseSelector, reason: str, work: Work) -> None:
    point = worker.point
    workers.remove(worker)
    selector.unregister(worker.output)
    worker.end()
    if point is not None:
        work.lost(point, worker.stage, reason)


def _there(stream: Any) -> IO[bytes]:
    if stream is None:
        raise WorkError("a worker has no streams")
    found: IO[bytes] = stream
    return found
