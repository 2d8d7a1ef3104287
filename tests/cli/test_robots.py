"""``amble robots``."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest

from amble.robot import catalogue, load_robot
from tests.cli.run import exit_code


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
        ('<dynamics damping="0.1" friction="0.25"/>', ["damping 0.1,", "friction 0.25,", "'transmission' (1)"]),
        ('<dynamics damping="0" friction="0.0"/>', ["'transmission' (1)"]),
        ("", ["'transmission' (1)"]),
    ],
)
def test_what_a_file_says_and_amble_does_not_use_is_listed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], dynamics: str, says: list[str]
) -> None:
    """Damping and friction of joints were read over in silence."""
    file = tmp_path / "hopper.urdf"
    file.write_text(FILE.format(dynamics=dynamics))
    assert exit_code("robots", str(file)) == 0
    notes = [line for line in capsys.readouterr().out.splitlines() if line.startswith("- ")]
    assert len(notes) == len(says)
    assert all(words in note for words, note in zip(says, notes, strict=True))
    robot = load_robot(file, {})
    assert len(robot.unused) == len(says)
    assert robot == replace(robot, unused=())  # it changes no motion
