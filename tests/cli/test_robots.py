"""``amble robots``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from amble.robot import catalogue, load_robot
from amble.robot.readers import READERS
from amble.robot.urdf import read_urdf
from tests.cli.run import exit_code
from tests.robots import path


def test_robots_lists_the_catalogue(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("robots") == 0
    header, *lines = capsys.readouterr().out.splitlines()
    assert header.split() == ["name", "mass", "(kg)", "joints", "feet"]
    assert [line.split()[0] for line in lines] == list(catalogue.names())
    assert lines[0].split() == ["astro", "21.50", "12", "fl", "rl", "fr", "rr"]


FILE = """<robot name="hopper"><transmission name="t"/>
<link name="body"><inertial><mass value="2"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<link name="leg"><inertial><mass value="1"/>
<inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial></link>
<joint name="hip" type="revolute"><parent link="body"/><child link="leg"/><axis xyz="0 1 0"/>
<limit lower="-1" upper="1" effort="10" velocity="5"/>{dynamics}</joint></robot>"""


@pytest.mark.parametrize(
    ("dynamics", "says"),
    [
        ('<calibration rising="0"/>', ["'calibration'", "'transmission' without motorInertia (1)"]),
        ('<dynamics damping="0.1" friction="0.25"/>', ["'transmission' without motorInertia (1)"]),
        ("", ["'transmission' without motorInertia (1)"]),
    ],
)
def test_what_a_file_says_and_amble_does_not_use_is_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], dynamics: str, says: list[str]
) -> None:
    """What is not used is said; damping and friction are used."""
    file = tmp_path / "hopper.urdf"
    file.write_text(FILE.format(dynamics=dynamics))
    assert exit_code("robots", str(file)) == 0
    said = capsys.readouterr().out.split("What the file says and amble does not use:")[1]
    notes = [line for line in said.splitlines() if line.startswith("- ")]
    assert len(notes) == len(says)
    assert all(words in note for words, note in zip(says, notes, strict=True))
    robot = load_robot(file, {})
    assert len(robot.unused) == len(says)
    assert robot == replace(robot, unused=())  # it changes no motion


def test_what_cannot_work_is_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    go2, feet = str(path("go2")), "fl=FL_foot,fr=FR_foot,rl=RL_foot,rr=RR_foot"
    assert exit_code("robots", go2) == 0
    assert f"no feet are named; by position these may be --feet {feet}" in capsys.readouterr().out
    assert exit_code("robots", go2, "--feet", feet) == 0
    said = capsys.readouterr().out
    assert "not left-right symmetric: the mass matrix deviates by 0.00085" in said
    assert "--symmetrize" in said
    file = tmp_path / "hopper.urdf"
    file.write_text(FILE.format(dynamics="").replace('lower="-1" upper="1"', 'lower="0" upper="0"'))
    assert exit_code("robots", str(file)) == 0
    assert "- joint 'hip' cannot move: its range is 0 to 0 rad" in capsys.readouterr().out
    assert exit_code("robots", "--feet", feet) == 2


def test_a_file_is_read_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """It was read and built a second time for the feet that it may have: half of the time of a long chain."""
    read: list[Path] = []
    monkeypatch.setitem(READERS._entries, "urdf", lambda file: (read.append(file), read_urdf(file))[1])
    assert exit_code("robots", str(path("go2"))) == 0
    assert read == [path("go2")]
