"""A worker is replaced where it hangs, dies, prints or takes too much memory; an input is the same in every process."""

from __future__ import annotations

import os
import time
from pathlib import Path

import pytest

from fuzz import worker as module
from fuzz.oracle import MEMORY
from fuzz.pool import Tally, Worker, run
from fuzz.registry import BY_NAME, READERS
from fuzz.worker import WALKER, content_of


@pytest.mark.parametrize("kind", [*BY_NAME, WALKER])
def test_a_seed_draws_the_same_input_again(kind: str) -> None:
    drawn = [content_of(kind, seed)[0] for seed in range(30)]
    assert drawn == [content_of(kind, seed)[0] for seed in range(30)]
    assert len(set(drawn)) > 15


def fault(seed: int) -> None:
    """What a reader may do wrong, one for every seed."""
    if seed == 0:
        while True:
            pass
    elif seed == 1:
        os.abort()
    elif seed == 2:
        os.write(1, b"a library says something\n")
    elif seed == 3:
        bytearray(2 * MEMORY)
    elif seed == 4:
        time.sleep(3600)


def faulty(kind: str, content: bytes, folder: Path) -> module.Verdict:
    """Stand in the place of the readers."""
    return module.judged(lambda path: fault(int(content)), folder)


def faulty_work(connection: object, cache: str) -> None:
    """A worker whose readers are faulty, with 1 s of processor time."""
    module.verdict_of = faulty
    module.seconds_of = lambda kind: 1
    module.work(connection, cache)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("seed", "signature"),
    [
        (0, "hang or death"),
        (1, "hang or death"),
        (2, "something is printed"),
        (3, "MemoryError"),
        pytest.param(4, "hang or death", marks=pytest.mark.slow),
    ],
)
def test_a_fault_of_a_process_is_seen(
    seed: int, signature: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr("fuzz.pool.work", faulty_work)
    # of wall time, in which a process also starts on a busy machine; only one that sleeps takes all of it
    monkeypatch.setattr("fuzz.pool.WAITING", 10 if seed == 4 else 120)
    monkeypatch.setattr("fuzz.pool.seconds_of", lambda kind: 1)
    worker = Worker(str(tmp_path))
    try:
        assert worker.ask("law", 0, str(seed).encode()).signature.startswith(signature)
        assert worker.ask("law", 0, b"9").outcome == "loaded"
    finally:
        worker.stop()


SLOW = ("trace", "transitions")


def test_every_kind_is_read_without_a_failure(tmp_path: Path) -> None:
    requests = [(kind.name, seed) for kind in READERS for seed in range(5 if kind.name not in SLOW else 2)]
    tally = run(requests, 1, 300.0, str(tmp_path))
    assert isinstance(tally, Tally)
    assert not tally.failures
    assert sum(tally.counts.values()) == len(requests)
    assert tally.counts["loaded"] > 3
