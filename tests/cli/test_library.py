"""``amble library``: what it says at the end, and its exit codes; libraries themselves are built in tests/workflow."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from amble.workflow.library import Library, LibraryEntry
from tests.cli.run import exit_code


def entry(speed: float, certified: bool, stage: str = "certify") -> LibraryEntry:
    return LibraryEntry(
        values={"speed": speed},
        certified=certified,
        stage=stage,
        reason="" if certified else "no",
        file=None,
        start=None,
        seconds={"solve": 0.5, "certify": 1.0},
    )


@pytest.mark.parametrize(("certified", "expected"), [(True, 0), (False, 1)])
def test_summary_and_exit_code(
    certified: bool,
    expected: int,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A library with failures is one; one without a gait is a failure."""
    asked: dict[str, Any] = {}

    def build(*_: Any, **options: Any) -> Library:
        asked.update(options)
        return Library(tmp_path, (entry(0.1, certified), entry(0.2, False, "solve"), entry(0.3, False, "check")))

    monkeypatch.setattr("amble.workflow.build_library", build)
    arguments = ("library", "x.toml", "--out", str(tmp_path / "out"), "--workers", "3", "--plugin", "json")
    assert exit_code(*arguments) == expected
    said = capsys.readouterr()
    assert f"{int(certified)} of 3 gaits certified; failed:" in said.out
    assert "1 at 'solve', 1 at 'check'; 1.5 s of processor time a gait" in said.out
    assert (asked["workers"], asked["plugins"]) == (3, ("json",))
    assert ("no gait of the library is certified" in said.err) is not certified
    assert exit_code(*arguments, "--json") == expected
    found = json.loads(capsys.readouterr().out)
    assert found["certified"] == int(certified)
    assert found["failed"]["solve"] == 1


def test_what_is_no_library_is_one_sentence(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spec = tmp_path / "spec.toml"
    spec.write_text('[robot]\nname = "astro"\n[gait]\nname = "amble"\nspeed = 0.2\n', encoding="utf-8")
    assert exit_code("library", str(spec), "--out", str(tmp_path / "out")) == 2
    assert "has no [library.axes]" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("workers", ["0", "-1", "257", "1.5", "slurm", "9" * 30, "²"])
def test_workers_that_cannot_be(workers: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ("library", str(tmp_path / "x.toml"), "--out", str(tmp_path / "out"), "--workers", workers)
    assert exit_code(*arguments) == 2
    assert "workers" in capsys.readouterr().err
    assert not list(tmp_path.iterdir())
