"""Processes of a pool: gaits that hang, end their process or answer late cost themselves only."""

from __future__ import annotations

import json
import os
import sys
import time
from dataclasses import replace
from pathlib import Path

import pytest

from amble.errors import WorkError
from amble.types import Json
from amble.workflow.library.grid import Point
from amble.workflow.library.pool import Work, run_pool

WORKER = """
import json, os, sys, time
print(json.dumps({'ready': True}), flush=True)
for line in sys.stdin:
    task = json.loads(line)
    print(json.dumps({"stage": "check", "at": "check"}), flush=True)
    print(json.dumps({"at": "check, node 3"}), flush=True)
    if task["do"] == "hang": time.sleep(3600)
    if task["do"] == "die": os.kill(os.getpid(), 9)
    if task["do"] == "fail": sys.exit("no luck")
    with open(task["log"], "a") as log: log.write(f"{os.getpid()}\\n")
    print(json.dumps({"done": task["do"]}), flush=True)
"""


class Recorded:
    """A list of tasks; what a pool reports of them."""

    def __init__(self, tasks: list[str], log: Path) -> None:
        self.tasks, self.log, self.waiting = tasks, log, list(range(len(tasks)))
        self.finished: list[int] = []
        self.missing: dict[int, tuple[str, str]] = {}

    def work(self) -> Work:
        def task(point: Point) -> Json:
            return {"do": self.tasks[point[0]], "log": str(self.log)}

        return Work(
            next=lambda: (self.waiting.pop(0),) if self.waiting else None,
            task=task,
            done=lambda point: self.finished.append(point[0]),
            lost=lambda point, stage, reason: self.missing.update({point[0]: (stage, reason)}),
            tell=lambda *_: None,
        )


@pytest.fixture
def command(tmp_path: Path) -> list[str]:
    path = tmp_path / "worker.py"
    path.write_text(WORKER, encoding="utf-8")
    return [sys.executable, "-S", str(path)]


@pytest.mark.parametrize("count", [1, 2])
def test_others_are_done_beside_what_hangs_and_dies(command: list[str], tmp_path: Path, count: int) -> None:
    recorded = Recorded(["work", "hang", "work", "die", "fail", "work"], tmp_path / "log")
    began = time.monotonic()
    run_pool(command, count, 0.5, recorded.work())
    assert time.monotonic() - began < 30.0
    assert sorted(recorded.finished) == [0, 2, 5]
    assert {place: stage for place, (stage, _) in recorded.missing.items()} == dict.fromkeys((1, 3, 4), "check")
    assert recorded.missing[1][1] == "it took more than 0.5 s"
    assert "SIGKILL" in recorded.missing[3][1]
    assert recorded.missing[4][1].endswith("exit code 1: no luck")


def test_one_process_does_many(command: list[str], tmp_path: Path) -> None:
    """A process is started once: what it has built is there for the next gait."""
    recorded = Recorded(["work"] * 5, tmp_path / "log")
    run_pool(command, 1, 10.0, recorded.work())
    assert recorded.finished == [0, 1, 2, 3, 4]
    assert len(set((tmp_path / "log").read_text().split())) == 1


def test_no_process_is_left(command: list[str], tmp_path: Path) -> None:
    recorded = Recorded(["work", "work"], tmp_path / "log")

    def interrupted(_: Point) -> None:
        raise KeyboardInterrupt

    work = recorded.work()
    with pytest.raises(KeyboardInterrupt):
        run_pool(command, 1, 10.0, replace(work, done=interrupted))
    (identifier,) = (tmp_path / "log").read_text().split()
    with pytest.raises(ProcessLookupError):
        os.kill(int(identifier), 0)


def test_a_process_that_cannot_begin_is_no_gaits_fault(tmp_path: Path) -> None:
    recorded = Recorded(["work"], tmp_path / "log")
    with pytest.raises(WorkError, match="a worker cannot be used: its process ended with exit code 1: no plugin"):
        run_pool([sys.executable, "-S", "-c", "import sys; sys.exit('no plugin')"], 1, 10.0, recorded.work())
    assert not recorded.missing


def test_answers_in_pieces(tmp_path: Path) -> None:
    """A line that arrives in two parts is one answer."""
    text = json.dumps({"done": "x"})
    script = (
        "import sys, time\nprint('{\"ready\": true}', flush=True)\nsys.stdin.readline()\n"
        f"print({text[:5]!r}, end='', flush=True); time.sleep(0.2); print({text[5:]!r}, flush=True)\nsys.stdin.read()"
    )
    recorded = Recorded(["work"], tmp_path / "log")
    run_pool([sys.executable, "-S", "-c", script], 1, 10.0, recorded.work())
    assert recorded.finished == [0]
