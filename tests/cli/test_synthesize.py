"""``amble synthesize``: what becomes of a problem without a solution, and of Ctrl-C."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from amble.gait.files import load_gait
from tests.cli.run import exit_code

IMPOSSIBLE = """
[robot]
name = "astro"
[gait]
name = "amble"
speed = "20 m/s"
[limits]
duration = ["10 ms", "200 ms"]
clearance = "20 mm"
normal_force = "5 N"
[solver]
intervals = {intervals}
iterations = {iterations}
"""


def test_a_speed_that_cannot_be_walked_exits_1_with_rows(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("spec.toml").write_text(IMPOSSIBLE.format(intervals=4, iterations=8))
    assert exit_code("synthesize", "spec.toml") == 1
    error = capsys.readouterr().err
    assert "error: not solved: " in error
    assert "(violated by" in error
    assert os.listdir() == ["spec.toml"]
    assert exit_code("synthesize", "spec.toml", "--keep", "last.json") == 1
    assert load_gait("last.json").solver.status not in ("", "Solve_Succeeded")


def test_ctrl_c_leaves_the_last_good_file(tmp_path: Path) -> None:
    # a problem that takes seconds to solve; the interrupt comes with the first iteration
    text = IMPOSSIBLE.format(intervals=24, iterations=500).replace("20 m/s", "0.2 m/s")
    (tmp_path / "spec.toml").write_text(text)
    (tmp_path / "gait.json").write_text("the last good file")
    command = [sys.executable, "-m", "amble", "synthesize", "spec.toml"]
    with subprocess.Popen(command, cwd=tmp_path, stderr=subprocess.PIPE, text=True) as running:
        assert running.stderr is not None
        for line in running.stderr:
            if line.startswith("optimising the gait: iteration"):
                running.send_signal(signal.SIGINT)
                break
        rest = running.stderr.read()
        assert running.wait() == 130, rest
    assert rest.splitlines()[-1].startswith("interrupted")
    assert "Traceback" not in rest
    assert sorted(os.listdir(tmp_path)) == ["gait.json", "spec.toml"]
    assert (tmp_path / "gait.json").read_text() == "the last good file"


def test_a_start_of_another_robot_exits_2(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gait = Path(__file__).parents[1] / "data" / "stabilised-amble.json"
    assert load_gait(gait).robot.name == "astro"
    spec = tmp_path / "spec.toml"
    spec.write_text(IMPOSSIBLE.format(intervals=4, iterations=8).replace('"astro"', '"astro_cad"'))
    assert exit_code("synthesize", str(spec), "--from", str(gait), "--out", str(tmp_path / "out.json")) == 2
    assert "gait of another robot" in capsys.readouterr().err
