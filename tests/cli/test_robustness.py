"""``amble robustness`` from a gait file to its page; the parts have tests of their own."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from amble.gait.files import load_gait, save_gait
from tests.cli.run import exit_code
from tests.conftest import DATA

GAIT = str(DATA / "stabilised-amble.json")


def test_bad_questions_exit_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = ["--out", str(tmp_path / "r")]
    assert exit_code("robustness", GAIT, "--friction", "0", *out) == 2
    assert exit_code("robustness", GAIT, "--engine", "bullet", *out) == 2
    assert "unknown engine 'bullet'" in capsys.readouterr().err
    from dataclasses import replace

    bare = save_gait(replace(load_gait(GAIT), feedback=None), tmp_path / "bare.json")
    assert exit_code("robustness", str(bare), *out) == 2


@pytest.mark.slow
def test_the_whole_command(tmp_path: Path) -> None:
    """A minute of processor time, most of it for reaches."""
    out = tmp_path / "r"
    assert exit_code("robustness", GAIT, "--trials", "60", "--workers", "1", "--out", str(out)) == 0
    numbers = json.loads((out / "robustness.json").read_text())["robustness"]
    assert numbers["trials"] == {"native": 60}
    assert 0.0 < numbers["spectral_radius"] < numbers["contraction_bound"] < 1.0
    assert len(numbers["cells"]) == 32
    assert (out / "robustness.html").stat().st_size > 10_000
