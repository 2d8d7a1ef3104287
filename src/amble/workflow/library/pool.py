"""Processes that make the gaits of a library: one that hangs or ends costs the gait that it is at, and no other."""

from __future__ import annotations

import contextlib
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


@dataclass(kw_only=True)
class Worker:
    """A process with the gait that it is at.

    Attributes:
        process: it.
        words: its standard error, a file.
        point: the gait; None while it waits for one.
        deadline: when the gait has to be done, by ``time.monotonic``.
        stage: of the gait, as it said last.
        ready: whether it has said so; what it does before is no gait's fault.
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
        return cls(process=process, words=words, deadline=time.monotonic() + PATIENCE)

    def begin(self, task: Json, time_limit: float) -> None:
        """Hand the task of its gait over."""
        self.stage, self.deadline = "", time.monotonic() + time_limit
        with contextlib.suppress(BrokenPipeError):  # it has ended, which is heard next
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
            with contextlib.suppress(OSError):  # a task that was never read
                stream.close()
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
        tell: what is being done with a gait.
    """

    next: Callable[[], Point | None]
    task: Callable[[Point], Json]
    done: Callable[[Point], None]
    lost: Callable[[Point, str, str], None]
    tell: Callable[[Point, str], None]


@dataclass(kw_only=True)
class Pool:
    """Processes at work; see ``run_pool`` for the fields."""

    command: Sequence[str]
    count: int
    time_limit: float
    work: Work
    selector: selectors.BaseSelector
    workers: list[Worker] = field(default_factory=list)

    def hand_out(self) -> None:
        """Give every process that waits a gait; start as many as there are gaits."""
        while True:
            idle = next((worker for worker in self.workers if worker.point is None), None)
            if idle is None and len(self.workers) >= self.count:
                return
            point = self.work.next()
            if point is None:
                return
            if idle is None:
                idle = Worker.started(self.command)
                self.workers.append(idle)
                self.selector.register(idle.output, selectors.EVENT_READ, idle)
            idle.point = point
            if idle.ready:
                idle.begin(self.work.task(point), self.time_limit)

    def hear(self) -> bool:
        """Wait for answers, at most until a gait has taken too long; false where no process is at work."""
        busy = [worker for worker in self.workers if worker.point is not None]
        if not busy:
            return False
        wait = max(min(worker.deadline for worker in busy) - time.monotonic(), 0.0)
        for key, _ in self.selector.select(wait):
            self._heard(key.data)
        for worker in busy:
            if worker in self.workers and worker.point is not None and time.monotonic() > worker.deadline:
                self._give_up(worker, f"it took more than {self.time_limit:g} s")
        return True

    def _heard(self, worker: Worker) -> None:
        answers = worker.answers()
        if answers is None:
            self._give_up(worker, worker.last_words(worker.end()))
            return
        for answer in answers:
            point = worker.point
            if point is None:
                continue
            if "ready" in answer:
                worker.ready = True
                worker.begin(self.work.task(point), self.time_limit)
            elif "done" in answer:
                worker.point = None
                self.work.done(point)
            else:
                worker.stage = str(answer.get("stage", worker.stage))
                self.work.tell(point, str(answer.get("at", worker.stage)))

    def _give_up(self, worker: Worker, reason: str) -> None:
        point = worker.point
        self.workers.remove(worker)
        self.selector.unregister(worker.output)
        worker.end()
        worker.words.close()
        if not worker.ready:
            raise WorkError(f"a worker cannot be used: {reason}")
        if point is not None:
            self.work.lost(point, worker.stage, reason)


def run_pool(command: Sequence[str], count: int, time_limit: float, work: Work) -> None:
    """Make gaits in processes until none is left that can be begun.

    Args:
        command: starts a process, which says that it is ready and then answers tasks (``worker``).
        count: how many at a time.
        time_limit: wall time after which a gait is given up, s.
        work: the gaits.

    Raises:
        WorkError: a process ends, or takes ``PATIENCE``, before it is ready: no gait is to blame.
    """
    with selectors.DefaultSelector() as selector:
        pool = Pool(command=command, count=count, time_limit=time_limit, work=work, selector=selector)
        try:
            pool.hand_out()
            while pool.hear():
                pool.hand_out()
        finally:
            for worker in pool.workers:
                worker.end()
                worker.words.close()


def _there(stream: Any) -> IO[bytes]:
    if stream is None:
        raise WorkError("a worker has no streams")
    found: IO[bytes] = stream
    return found
