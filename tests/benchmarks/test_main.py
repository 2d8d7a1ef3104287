"""The runner of the benchmarks: names, the summary, and the report that is written as it goes."""

from __future__ import annotations

import json
from pathlib import Path
from types import SimpleNamespace

import pytest

from benchmarks import __main__ as runner
from benchmarks import fleet, fleet_row, fleet_style, report
from benchmarks.figures import Figure

FIGURES = [Figure("fast", 1.0, "s", most=2.0), Figure("slow", 3.0, "s", most=2.0), Figure("free", 9.0, "s")]


def test_the_summary_names_what_was_missed() -> None:
    assert runner._summary({"one": FIGURES}) == "1 of 2 limits met\nMISSED one: slow"


def test_unknown_benchmark(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr(runner, "names", lambda: ["one", "two"])
    assert runner.run(["nothing"]) == 2
    assert "unknown benchmark 'nothing'; known: one, two" in capsys.readouterr().err


def test_an_interrupted_run_keeps_what_was_finished(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    def interrupt() -> list[Figure]:
        raise KeyboardInterrupt

    modules = {"one": SimpleNamespace(measure=lambda: FIGURES), "two": SimpleNamespace(measure=interrupt)}
    monkeypatch.setattr(report, "FOLDER", tmp_path)
    monkeypatch.setattr(runner, "names", lambda: list(modules))
    monkeypatch.setattr(runner.importlib, "import_module", lambda name: modules[name.removeprefix("benchmarks.")])
    with pytest.raises(KeyboardInterrupt):
        runner.run([])
    tree = json.loads((tmp_path / "benchmarks.json").read_text())
    assert [figure["verdict"] for figure in tree["figures"]["one"]] == ["met", "MISSED", ""]
    assert "| one | slow | 3 | s | <= 2 | MISSED | 1 |" in (tmp_path / "benchmarks.md").read_text()


def test_what_wants_arguments_is_no_benchmark() -> None:
    """``fleet_row`` is a process of ``fleet``; a run of all called it without its arguments."""
    assert runner._is_benchmark(fleet)
    assert not any(map(runner._is_benchmark, (fleet_row, fleet_style, report)))
