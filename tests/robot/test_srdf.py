"""Postures of the SRDF beside a robot's file: which file, which state, and what is refused in a sentence."""

from __future__ import annotations

import logging
import shutil
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError
from amble.robot import Robot, kinematics, load_robot
from amble.robot.proposal import standing_posture
from amble.robot.srdf import LARGEST, MOST_FILES, read_srdf, srdf_posture
from amble.synthesis.specified import problem_of
from amble.workflow.proposal import described, with_file_posture, written
from benchmarks.robot_files import FILES
from tests.robots import path

FEET = {"l": "l_foot", "r": "r_foot"}


@pytest.fixture
def file(tmp_path: Path) -> Path:
    """The planar biped's file, alone in a folder beside another."""
    place = tmp_path / "urdf" / "biped.urdf"
    place.parent.mkdir()
    shutil.copy(path("planar_biped"), place)
    return place


def robot(file: Path) -> Robot:
    return load_robot(file, FEET)


def srdf(robot: Robot, state: str = "standing", name: str = "biped", **change: object) -> str:
    angles: dict[str, object] = {**standing_posture(robot).angles, **change}
    joints = "".join(f'<joint name="{joint}" value="{angle}"/>' for joint, angle in angles.items() if angle is not None)
    base = '<joint name="root_joint" value="0 0 0.3 0 0 0 1"/>'
    return f'<robot name="{name}"><group_state name="{state}" group="all">{base}{joints}</group_state></robot>'


@pytest.mark.parametrize("place", ["urdf/biped.srdf", "urdf/srdf/biped.srdf", "srdf/biped.srdf", "srdf/other.srdf"])
def test_the_file_beside_is_found(file: Path, place: str) -> None:
    there = file.parent.parent / place
    there.parent.mkdir(exist_ok=True)
    there.write_text(srdf(robot(file), name=robot(file).name))
    found = srdf_posture(robot(file), file)
    assert found is not None
    assert (found.state, found.file) == ("standing", there)
    assert found.posture.angles == standing_posture(robot(file)).angles
    q = found.posture.coordinates(robot(file))
    heights = [float(np.asarray(kinematics.foot_position(robot(file), foot, q)).ravel()[2]) for foot in FEET]
    assert max(np.abs(heights)) < 0.05 * robot(file).leg_length
    assert min(heights) == pytest.approx(0.0, abs=1e-12)  # the base is as high as its lowest foot is below it


def test_another_robots_file_is_not_its(file: Path) -> None:
    (file.parent / "other.srdf").write_text(srdf(robot(file), name="somebody else"))
    assert srdf_posture(robot(file), file) is None


@pytest.mark.parametrize(
    ("change", "says"),
    [
        ({"l_knee": None}, "no angle of joint 'l_knee'"),
        ({"l_knee": 100.0}, "100 is beyond the limits of joint 'l_knee'"),
        ({"l_hip": -0.22}, "m below a level base"),
    ],
)
def test_a_state_that_is_no_posture_is_told(
    file: Path, change: dict[str, object], says: str, caplog: pytest.LogCaptureFixture
) -> None:
    (file.parent / "biped.srdf").write_text(srdf(robot(file), **change))
    with caplog.at_level(logging.WARNING, "amble"):
        assert srdf_posture(robot(file), file) is None
    assert says in caplog.text


def test_standing_comes_before_other_states(file: Path) -> None:
    crouched, standing = (srdf(robot(file), state) for state in ("crouched", "standing"))
    both = crouched.replace("</robot>", "") + standing.partition('"biped">')[2]
    (file.parent / "biped.srdf").write_text(both)
    found = srdf_posture(robot(file), file)
    assert found is not None
    assert found.state == "standing"


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("<robot", "not well-formed XML"),
        ("<srdf/>", "is not a SRDF: its root element is 'srdf'"),
        ('<robot name="a"><group_state/></robot>', "'group_state' element without 'name'"),
        ('<robot><group_state name="s"><joint name="j"/></group_state></robot>', "'joint' element without 'value'"),
        ('<robot><group_state name="s"><joint name="j" value="x"/></group_state></robot>', "'x', not a number"),
        ('<robot><group_state name="s"><joint name="j" value="inf"/></group_state></robot>', "not a finite number"),
    ],
)
def test_what_is_no_srdf_is_refused_and_told(
    file: Path, text: str, says: str, caplog: pytest.LogCaptureFixture
) -> None:
    there = file.parent / "biped.srdf"
    there.write_text(text)
    with pytest.raises(InputError, match=says):
        read_srdf(there)
    with caplog.at_level(logging.WARNING, "amble"):
        assert srdf_posture(robot(file), file) is None
    assert says in caplog.text


def test_init_writes_it(file: Path, tmp_path: Path) -> None:
    asked = described(str(file), FEET, "walk", 0.3)
    assert with_file_posture(asked) == (asked, "")
    angles = {**standing_posture(robot(file)).angles}
    (file.parent / "biped.srdf").write_text(srdf(robot(file)))
    found, source = with_file_posture(asked)
    assert source == "group state 'standing' of biped.srdf"
    problem = problem_of(found)
    assert dict(problem.posture.angles) == angles
    assert f"height = {problem.posture.height!r}" in written(found, problem, tmp_path)
    assert with_file_posture(described("astro", {}, "trot", 0.2))[1] == ""


@pytest.mark.parametrize("name", ["go1", "hyq", "anymal_c", "solo8", "bolt"])
def test_real_files_have_one(name: str) -> None:
    known = FILES[name]
    if known.absent:
        pytest.skip(known.absent)
    found = srdf_posture(load_robot(known.place(), known.feet), known.place())
    assert found is not None
    assert found.state == "standing"


def test_more_states_and_bytes_than_a_robot_has_are_refused(file: Path, caplog: pytest.LogCaptureFixture) -> None:
    beside = file.parent / "biped.srdf"
    beside.write_text('<robot name="biped">' + '<group_state name="a"/>' * 101 + "</robot>")
    with pytest.raises(InputError, match="more than 100 group states"):
        read_srdf(beside)
    beside.write_text('<robot name="biped">' + " " * LARGEST + "</robot>")
    with caplog.at_level(logging.WARNING, "amble"):
        assert srdf_posture(robot(file), file) is None
    assert "more than 2 MB" in caplog.text


def test_of_many_files_beside_some_are_read(file: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    for number in range(40):
        (file.parent / f"other{number}.srdf").write_text("<robot/>")
    read = []
    monkeypatch.setattr("amble.robot.srdf.read_srdf", lambda path: (read.append(path), ("", {}))[1])
    assert srdf_posture(robot(file), file) is None
    assert len(read) == MOST_FILES


def test_a_name_of_any_length_is_told_in_a_short_sentence(file: Path, caplog: pytest.LogCaptureFixture) -> None:
    (file.parent / "biped.srdf").write_text(srdf(robot(file), state="a" * 100_000, l_knee=100.0))
    with caplog.at_level(logging.WARNING, "amble"):
        assert srdf_posture(robot(file), file) is None
    assert len(caplog.records[0].getMessage()) < 400
    long = file.with_name(f"{'n' * 250}.xml")  # with .srdf it is no name of a file
    shutil.move(file, long)
    assert srdf_posture(load_robot(long, FEET, format="urdf"), long) is None
