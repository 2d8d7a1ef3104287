"""A place that cannot be written is refused before the work, with one sentence."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.cli.run import exit_code

GAIT = str(Path(__file__).parents[1] / "data" / "stabilised-amble.json")


@pytest.fixture(autouse=True)
def no_work(monkeypatch: pytest.MonkeyPatch) -> None:
    """Reading the gait would be the first work."""

    def work(*_: object) -> None:
        raise AssertionError("the work has begun")

    for reader in ("amble.gait.files.load_gait", "amble.synthesis.specification.read_specification"):
        monkeypatch.setattr(reader, work)


@pytest.mark.parametrize("place", [".", "/", "/proc/amble/x", "/dev/null/x"])
@pytest.mark.parametrize(
    "command",
    [
        ("synthesize", "spec.toml", "--out"),
        ("synthesize", "spec.toml", "--keep"),
        ("stabilize", GAIT, "--out"),
        ("certify", GAIT, "--out"),
        ("simulate", GAIT, "--out"),
        ("compare", GAIT, "--out"),
    ],
)
def test_files(
    command: tuple[str, ...],
    place: str,
    capsys: pytest.CaptureFixture[str],
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.chdir(tmp_path)
    assert exit_code(*command, place) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: cannot write")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("place", ["/proc/amble", "/dev/null", GAIT])
@pytest.mark.parametrize("command", [("reproduce",), ("report", ".")])
def test_folders(command: tuple[str, ...], place: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code(*command, "--out", place) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line.startswith("error: cannot write")


def test_figures(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("compare", GAIT, "--figure", "/proc/amble/torques") == 2
    assert capsys.readouterr().err.startswith("error: cannot write")
