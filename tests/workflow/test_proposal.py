"""From a robot, a gait and a speed to a specification that says everything."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path

import pytest

from amble.errors import InputError
from amble.robot.proposal import proposed_feet
from amble.robot.readers import READERS
from amble.robot.urdf import read_urdf
from amble.synthesis.specification import RobotSection, read_specification
from amble.synthesis.specified import OF_FILES, problem_of, robot_of
from amble.workflow.proposal import _adaptation, _robot, described, written
from benchmarks.robot_files import FILES
from tests.robots import _FILES, path


@pytest.mark.parametrize("name", [*_FILES, "astro"])
@pytest.mark.parametrize("gait", ["trot", "amble"])
def test_the_written_specification_poses_the_same_problem(name: str, gait: str, tmp_path: Path) -> None:
    """Every number is written so that it is read back exactly, and nothing is left to a default that may change."""
    if name == "astro":
        asked = described("astro", {}, gait, "0.72 km/h")
    else:
        asked = described(str(path(name)), proposed_feet(path(name)), gait, 0.3)
    problem = problem_of(asked)
    file = tmp_path / "spec.toml"
    file.write_text(written(asked, problem, tmp_path))
    again = read_specification(file)
    # the file says which outputs there are
    assert problem_of(again, tmp_path) == replace(problem, outputs_by_default=False)
    sections = {"robot", "gait", "ground", "outputs", "law", "cost", "limits", "posture", "solver"}
    assert sections == again.model_fields_set


ADAPTED = """
locked = { FL_hip_joint = 0.1 }
base_rotation = [0.0, 0.05, 0.0]
foot_offsets = { fl = [0.0, 0.0, 0.01] }
payload = { mass = 1.5, position = [0.1, 0.0, 0.05], link = "base" }
rotor_inertia = 0.01
dampings = { FR_hip_joint = 0.2 }
dry_friction = "0.1 N m"
friction_width = 0.7
file_drives = false
symmetrize = false
[gait]
name = "trot"
speed = 0.3
"""


def test_an_adapted_robot_is_written_whole(tmp_path: Path) -> None:
    """A specification that is written again from its problem lost what it changes of the robot's file."""
    feet = ", ".join(f'{label} = "{frame}"' for label, frame in _FILES["go2"].feet.items())
    first, second = tmp_path / "first.toml", tmp_path / "second.toml"
    first.write_text(f'[robot]\nfile = "{path("go2")}"\nfeet = {{ {feet} }}{ADAPTED}')
    asked = read_specification(first)
    robot = robot_of(asked.robot, tmp_path)
    second.write_text(
        "[robot]\n" + "\n".join(_robot(asked, robot, tmp_path)) + '\n[gait]\nname = "trot"\nspeed = 0.3\n'
    )
    assert robot_of(read_specification(second).robot, tmp_path) == robot
    assert not robot.joints[0].driven_freely
    assert robot.payload is not None


def test_keys_that_are_not_used_are_shown_as_comments_that_would_read() -> None:
    """Every key of [robot] that adapts a file is there, and its example is one."""
    section = RobotSection(file="go2.urdf", feet={"fl": "FL_foot"})
    lines = _adaptation(section)
    found = tomllib.loads("\n".join(line.removeprefix("# ") for line in lines))
    assert set(found) == set(RobotSection.model_fields) - OF_FILES - {"name", "file"} | {"foot_radius"}
    RobotSection.model_validate({"file": "go2.urdf", **found})


@pytest.mark.parametrize("name", _FILES)
def test_feet_are_proposed_by_position(name: str) -> None:
    assert proposed_feet(path(name)) == _FILES[name].feet


def test_the_file_is_read_once(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    """Twice, a file that was written in between gave frames of another robot; and what it says was logged too."""
    read: list[Path] = []
    monkeypatch.setitem(READERS._entries, "urdf", lambda file: (read.append(file), read_urdf(file))[1])
    proposed_feet(path("go2"))
    assert read == [path("go2")]
    assert not caplog.records


def test_two_legs_are_left_and_right() -> None:
    bolt = FILES["bolt"]
    if bolt.absent:
        pytest.skip(bolt.absent)
    assert proposed_feet(bolt.place()) == bolt.feet


def test_what_has_no_legs_gets_no_proposal(tmp_path: Path) -> None:
    file = tmp_path / "arm.urdf"
    inertia = '<inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/>'
    body = f'<link name="{{}}"><inertial><mass value="1"/>{inertia}</inertial></link>'
    joint = '<joint name="{0}{1}" type="continuous"><parent link="{0}"/><child link="{1}"/><axis xyz="0 1 0"/></joint>'
    file.write_text(
        f"<robot name='arm'>{''.join(map(body.format, 'abc'))}{joint.format(*'ab')}{joint.format(*'bc')}</robot>"
    )
    with pytest.raises(InputError, match="1 chains of joints could be legs, so no feet are proposed"):
        proposed_feet(file)


def test_what_is_asked_for_wrongly_is_one_sentence() -> None:
    with pytest.raises(InputError, match=r"'gait.speed': '0.3' has no unit"):
        described("astro", {}, "trot", "0.3")
    with pytest.raises(InputError, match="takes no symmetrize"):
        problem_of(described("astro", {}, "trot", 0.3, symmetrize=True))
