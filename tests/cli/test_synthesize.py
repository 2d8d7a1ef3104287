"""``amble synthesize``: what becomes of a problem without a solution, and of Ctrl-C."""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from amble.cli.options import is_robot
from amble.gait.files import load_gait
from amble.gait.style import Style
from amble.robot.readers import READERS
from amble.robot.urdf import read_urdf
from tests.cli.run import exit_code
from tests.robots import path as urdf

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


def test_a_robot_a_gait_and_a_speed_are_enough(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first trot of a Go2 took twelve failing runs, and 28 numbers by hand."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    shutil.copy(urdf("go2"), "go2.urdf")  # without the SRDF beside it, whose posture `init` would take
    go2, feet = "go2.urdf", "fl=FL_foot,fr=FR_foot,rl=RL_foot,rr=RR_foot"
    assert exit_code("synthesize", go2) == 2
    said = capsys.readouterr().err
    assert f"--feet (by position these may be {feet}); --gait (" in said
    assert said.rstrip().endswith("; --speed (m/s)")
    assert exit_code("synthesize", go2, "--feet", feet, "--gait", "trot", "--speed", "0.4") == 0
    assert exit_code("init", go2, "--gait", "trot", "--speed", "0.4", "--out", "spec.toml") == 0
    assert (
        f"feet by position, to be confirmed: {feet.replace('=', ' = ').replace(',', ', ')}" in capsys.readouterr().out
    )
    assert exit_code("synthesize", "spec.toml", "--out", "again.json") == 0
    one, again = load_gait("gait.json"), load_gait("again.json")
    assert one.solver.objective == again.solver.objective
    assert exit_code("check", "gait.json", "--robot", go2) == 0


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("spec.toml", "--speed", "1"), "is a specification, which holds feet, gait and speed itself"),
        (("astro", "--gait", "trot"), "robot 'astro' needs also --speed"),
        (("astro", "--gait", "trot", "--speed", "1", "--feet", "a=b"), "takes neither --feet nor --symmetrize"),
        (("x.urdf", "--gait", "trot", "--speed", "1", "--feet", "fl"), "is not a list label=link"),
        (("x.urdf", "--gait", "trot", "--speed", "1", "--feet", "fl=a,fl=b"), "with every label once"),
        (("astro", "--gait", "trot", "--speed", "1 kn"), "unknown unit 'kn'"),
        (("astro", "--gait", "gallop", "--speed", "1"), "unknown gait 'gallop'"),
    ],
)
def test_options_that_do_not_fit_exit_2(
    arguments: tuple[str, ...], says: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert exit_code("synthesize", *arguments) == 2
    assert says in capsys.readouterr().err


def test_a_robot_is_told_from_a_specification_by_the_formats_that_are_registered(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A robot of a plug-in's format was read as a specification, which it is not."""
    monkeypatch.setattr(READERS, "_entries", {**READERS._entries, "legs": read_urdf})
    shutil.copy(urdf("go2"), tmp_path / "go2.legs")
    assert exit_code("synthesize", str(tmp_path / "go2.legs")) == 2
    assert "needs also --feet (by position these may be fl=FL_foot" in capsys.readouterr().err
    assert [is_robot(word) for word in ("a.XML", "a.urdf", "astro")] == [True] * 3
    assert [is_robot(word) for word in ("a.toml", "a.txt")] == [False] * 2


def test_a_style_is_asked_for_and_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """By the command line, in the specification that `amble init` writes, and in the gait's file."""
    monkeypatch.chdir(tmp_path)
    file = str(urdf("planar_biped"))
    asked = ("--feet", "l=l_foot,r=r_foot", "--gait", "walk", "--speed", "0.5", "--cost", "style:attitude=10,power=0.1")
    assert exit_code("init", file, *asked) == 0
    assert 'name = "style"\nparameters = { torques = 1.0, power = 0.1, ' in Path("spec.toml").read_text()
    assert exit_code("synthesize", "spec.toml") == 0
    assert load_gait("gait.json").cost == Style(attitude=10.0, power=0.1)
    assert exit_code("synthesize", "spec.toml", "--cost", "style") == 2
    assert exit_code("init", file, *asked[:-1], "style:power=-1") == 2
    assert exit_code("init", file, *asked[:-1], "stile") == 2


@pytest.mark.slow
def test_one_line_leads_from_a_file_to_a_certificate(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Bolt's walk with defaults only; joints are freed by themselves, since the base alone leaves a radius above 1."""
    monkeypatch.chdir(tmp_path)
    words = ("synthesize", str(urdf("bolt")), "--feet", "l=FL_FOOT,r=FR_FOOT", "--gait", "walk", "--speed", "0.23")
    assert exit_code(*words, "--certify", "--out", "walk.json") == 0
    shown = capsys.readouterr().out
    assert "wrote walk.json" in shown
    assert "wrote certificate.json" in shown
    assert load_gait("walk.json").feedback is not None
    assert json.loads(Path("certificate.json").read_text())["spectral_radius"] < 0.95
