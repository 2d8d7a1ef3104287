"""``amble view``."""

from __future__ import annotations

import webbrowser
from pathlib import Path

import pytest

from tests.cli.run import exit_code

GAIT = str(Path(__file__).parents[1] / "data" / "stabilised-amble.json")


def test_a_page_is_written_and_no_browser_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda _: pytest.fail("a browser was opened"))
    page, trace = tmp_path / "replay.html", tmp_path / "trace.nc"
    assert exit_code("simulate", GAIT, "--cycles", "1", "--out", str(trace)) == 0
    assert exit_code("view", GAIT, "--trace", str(trace), "--cycles", "1", "--html", str(page)) == 0
    assert f"wrote {page}" in capsys.readouterr().out
    assert "astro, amble, simulated" in page.read_text(encoding="utf-8")


def test_without_a_file_the_browser_shows_it(monkeypatch: pytest.MonkeyPatch) -> None:
    opened: list[str] = []
    monkeypatch.setattr(webbrowser, "open", lambda address: opened.append(address) is None)
    assert exit_code("view", GAIT, "--cycles", "1") == 0
    assert opened[0].startswith("file:///")
    assert opened[0].endswith("replay.html")


def test_without_a_browser_it_says_how(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(webbrowser, "open", lambda _: False)
    assert exit_code("view", GAIT, "--cycles", "1") == 1
    assert "--html FILE" in capsys.readouterr().err


def test_three_motions_are_too_many(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("view", GAIT, "--trace", "a.nc", "--beside", GAIT) == 2
    assert capsys.readouterr().err == (
        "error: a page shows two motions side by side: give --trace or --beside, not both\n"
    )
