"""Ctrl-C while a solver works."""

from __future__ import annotations

import os
import signal
from typing import Any

import pytest

from amble.progress import ProgressReport
from amble.synthesis.program import GaitProgram
from amble.synthesis.watch import Watch


def test_an_interrupt_waits_for_the_end_of_the_block(small_program: GaitProgram) -> None:
    watch = Watch(small_program, None)
    before = signal.getsignal(signal.SIGINT)
    reached = []

    def work() -> None:
        with watch.keeping_interrupts():
            os.kill(os.getpid(), signal.SIGINT)
            reached.append("the end")

    with pytest.raises(KeyboardInterrupt):
        work()
    assert reached == ["the end"]
    assert signal.getsignal(signal.SIGINT) is before
    assert watch.eval([]) == [1]


def test_without_an_interrupt_the_solver_goes_on(small_program: GaitProgram) -> None:
    watch = Watch(small_program, None)
    with watch.keeping_interrupts():
        assert watch.eval([]) == [0]


def test_an_interrupt_of_the_progress_stops_the_solver(small_program: GaitProgram, monkeypatch: Any) -> None:
    def interrupted(_: ProgressReport) -> None:
        raise KeyboardInterrupt

    watch = Watch(small_program, interrupted)
    monkeypatch.setattr(Watch, "_report", lambda _, progress, __: progress(ProgressReport(what="iteration")))
    assert watch.eval([]) == [1]
