"""The oracle sees every kind of fault that it is there for."""

from __future__ import annotations

import warnings
from collections.abc import Callable
from pathlib import Path

import pytest

from amble.errors import InputError, WorkError
from fuzz.oracle import judged

HERE = Path(__file__)


def raising(error: BaseException) -> Callable[[Path], None]:
    def read(path: Path) -> None:
        raise error

    return read


@pytest.mark.parametrize(
    ("read", "signature"),
    [
        (raising(IndexError("a")), "IndexError in"),
        (raising(MemoryError()), "MemoryError in"),
        (raising(RecursionError()), "RecursionError in"),
        (raising(SystemExit(0)), "SystemExit in"),
        (lambda path: warnings.warn("overflow", RuntimeWarning, stacklevel=1), "RuntimeWarning in"),
        (raising(WorkError("the work failed")), "exit code 1"),
        (raising(InputError("")), "no printable sentence"),
        (raising(InputError("x" * 6000)), "no printable sentence"),
    ],
)
def test_a_fault_is_seen(read: Callable[[Path], None], signature: str) -> None:
    verdict = judged(read, HERE)
    assert verdict.outcome == "failed"
    assert verdict.signature.startswith(signature)


def test_a_control_character_is_no_sentence() -> None:
    error = WorkError("a\x1b[31m")
    assert judged(raising(error), HERE, exit_codes=(1, 2)).signature.startswith("no printable sentence")


def test_reading_and_refusing_are_no_faults() -> None:
    assert judged(lambda path: path, HERE).outcome == "loaded"
    assert judged(raising(InputError("the file is not one")), HERE).outcome == "refused"
    assert judged(raising(WorkError("a\nb")), HERE, exit_codes=(1, 2)).outcome == "refused"
