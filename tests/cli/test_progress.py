"""Progress where standard error is not a terminal: the task at once, then a line now and then."""

from __future__ import annotations

import io
import sys

import pytest

from amble.cli import console as module
from amble.cli.console import PAUSE, progress
from amble.progress import ProgressReport


class Clock:
    """A clock that the test moves."""

    now = 100.0

    @classmethod
    def monotonic(cls) -> float:
        return cls.now


def test_lines_come_at_once_and_then_now_and_then(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(module, "time", Clock)
    with progress("walking") as update:
        assert capsys.readouterr().err == "walking ...\n"
        shown = []
        for number in range(21):
            Clock.now = 100.0 + number * PAUSE / 10
            update(ProgressReport(what="step", done=number))
            shown.append(capsys.readouterr().err)
    assert [number for number, text in enumerate(shown) if text] == [0, 10, 20]
    assert shown[20] == "walking: step 20\n"


def test_nothing_is_said_on_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    with progress("walking") as update:
        update(ProgressReport(what="step", done=1))
    assert capsys.readouterr().out == ""


def test_a_terminal_shows_names_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """rich read "[/red]" in the name of a row as the end of a markup, and ended the work with a traceback."""

    class Terminal(io.StringIO):
        def isatty(self) -> bool:
            return True

    monkeypatch.setattr(sys, "stderr", Terminal())
    monkeypatch.setenv("TERM", "xterm")
    with progress("walking") as update:
        update(ProgressReport(what="worst row 'height [/red]'"))
