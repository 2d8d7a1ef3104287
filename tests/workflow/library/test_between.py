"""Transitions of a library: what is written is what is read, and what does not belong together is refused."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import content_hash, load_gait, save_gait
from amble.gait.impedance import Impedance
from amble.gait.schedule import Schedule
from amble.stability.sampled_step import SampledStep
from amble.stability.scheduled import Tracking
from amble.workflow.library import between
from amble.workflow.library.axes import read_library
from amble.workflow.library.between import FOLDER, HEADER, load_transitions, transitions
from amble.workflow.library.entry import Made
from amble.workflow.library.files import claim_folder, load_library, write_entry
from tests.cli.run import exit_code
from tests.conftest import DATA
from tests.workflow.library.test_axes import written


@pytest.fixture
def folder(tmp_path: Path, stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A library of one gait at two speeds."""
    place = tmp_path / "library"
    claim_folder(place, read_library(written(tmp_path, "speed = { range = [0.2, 0.3], step = 0.1 }")))
    monkeypatch.setattr("amble.workflow.library.files.certificate_to_dict", _told)
    for speed in (0.2, 0.3):
        certified: Any = SimpleNamespace()
        write_entry(place, {"speed": speed}, None, Made(stage="certify", gait=stabilised_gait, certificate=certified))
    return place


def _told(gait: Gait, certificate: object) -> dict[str, object]:
    del certificate
    return {"gait": {"content_hash": content_hash(gait)}}


def _tracking(schedule: Schedule, **_: object) -> Tracking:
    leads = np.arange(2.0 * 2 * 12).reshape(2, 1, 2, 12)
    matrices = (0.5 * np.eye(33),)
    sample = SampledStep(command=(0.2,), state=np.zeros(36), matrices=matrices, duration=0.15, speed=0.2, yaw_rate=0.0)
    return Tracking(
        schedule=replace(schedule, leads=leads),
        samples=(sample,),
        rate=0.5,
        metric=np.eye(33),
        tried=(0.02,),
        changes=(0.01,),
    )


@pytest.fixture
def steerable(folder: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same without the work: gains as they are, and a change of 0.01 m/s a step."""
    monkeypatch.setattr(between, "track", _tracking)
    monkeypatch.setattr(between, "stabilization", lambda gait, **_: SimpleNamespace(gait=gait))
    transitions(folder, friction=0.7)
    return folder


def test_what_is_written_is_read(steerable: Path, stabilised_gait: Gait) -> None:
    found = load_transitions(steerable)
    assert (found.axes, found.changes, found.friction) == (("speed",), (0.01,), 0.7)
    assert found.schedule.values == ((0.2, 0.3),)
    np.testing.assert_array_equal(found.schedule.lead((0.3,)).ravel(), np.arange(24.0, 48.0))
    own = Impedance().numbers(stabilised_gait, None)
    for entry, expected in zip(found.schedule.law([0.25]).entries, own, strict=True):
        np.testing.assert_allclose(entry.parameters[:26], expected.parameters[:26], rtol=1e-13)
    told = json.loads((steerable / FOLDER / HEADER).read_text())
    assert told["orbits"][0]["radius_of_a_step"] == 0.5
    assert len(load_library(steerable).certified) == 2  # its folder does not disturb the library


def test_a_gait_that_was_changed_is_refused(steerable: Path, stabilised_gait: Gait) -> None:
    save_gait(replace(stabilised_gait, control=Impedance(stance_damping=1.0)), steerable / FOLDER / "speed_0.3.json")
    with pytest.raises(InputError, match="changed after it was made"):
        load_transitions(steerable)


FORGED: dict[str, dict[str, object]] = {
    "another format": {"format": "amble gait"},
    "another version": {"format_version": 1},
    "leads of other gaits": {"leads": [0.0]},
    "an axis that no command changes": {"axes": ["friction"]},
    "more axes than changes": {"axes": ["speed", "height"]},
    "a change in words": {"changes": ["much"]},
    "a negative change": {"changes": [-0.1]},
    "a change without end": {"changes": [float("inf")]},
    "gaits of another library": {"gaits": {"speed_0.2": "0" * 64, "../../speed_0.9": "0" * 64}},
    "one gait": {"gaits": {"speed_0.2": "0" * 64}},
    "a friction that is none": {"friction": 0.0},
}


def test_a_forged_record_is_refused(steerable: Path) -> None:
    path = steerable / FOLDER / HEADER
    sound = json.loads(path.read_text())
    for what, forged in FORGED.items():
        path.write_text(json.dumps({**sound, **forged}))
        with pytest.raises(InputError) as refused:
            load_transitions(steerable)
        assert "\n" not in str(refused.value), what


def test_a_library_without_transitions_says_so(folder: Path) -> None:
    with pytest.raises(InputError, match="transitions"):
        load_transitions(folder)


def test_only_what_can_be_commanded_is_steered_along(folder: Path) -> None:
    library = load_library(folder)
    one = replace(library, entries=library.entries[:1])
    with pytest.raises(InputError, match="1 certified gaits, and no axis with two values"):
        transitions(one)
    slopes = tuple(replace(entry, values={"speed": 0.2, "slope": at}) for at, entry in enumerate(library.entries))
    with pytest.raises(InputError, match="several values of slope, which no command can change"):
        transitions(replace(library, entries=slopes))
    with pytest.raises(InputError, match="friction"):
        transitions(library, friction=-1.0)


def test_gaits_that_cannot_be_steered_are_refused_before_the_work(
    folder: Path, stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Gains for each of them would be looked for first, a minute a gait."""
    trot = load_gait(DATA / "stabilised-trot-one-by-one.json")
    monkeypatch.setattr(
        "amble.workflow.library.files.Library.gait",
        lambda _, entry: trot if entry.values["speed"] > 0.25 else stabilised_gait,
    )
    monkeypatch.setattr(between, "stabilization", None)
    with pytest.raises(InputError, match="the gaits differ in robot, stances, landing rule or ground"):
        transitions(folder)


@pytest.mark.slow
def test_the_command_line_steers_and_exports(
    steerable: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    commands, out = tmp_path / "commands.csv", tmp_path / "steered.csv"
    commands.write_text("time,speed\n0,0.2\n0.01,0.25\n")
    arguments = ("steer", str(steerable), "--commands", str(commands), "--duration", "0.3", "--out", str(out))
    assert exit_code(*arguments) == 0
    followed = [float(row.split(",")[2]) for row in out.read_text().splitlines()[1:]]
    assert followed == pytest.approx([0.2, 0.21])
    assert exit_code("export", str(steerable), "--out", str(tmp_path / "controller")) == 0
    said = capsys.readouterr().out
    assert "tables of 2 gaits" in said
    header = (tmp_path / "controller" / "amble_controller.h").read_text()
    assert "#define AMBLE_AXES 1" in header
    assert "speed 0.2 to 0.3 (2 gaits)" in header
    assert exit_code("export", str(steerable), "--law", "pinv", "--out", str(tmp_path / "other")) == 2
    assert exit_code("export", str(tmp_path), "--out", str(tmp_path / "other")) == 2


def test_a_link_in_the_place_of_transitions_is_not_followed(folder: Path, tmp_path: Path) -> None:
    (tmp_path / "outside").mkdir()
    (folder / FOLDER).symlink_to(tmp_path / "outside")
    with pytest.raises(InputError, match="leads out of it"):
        transitions(folder)
    assert not list((tmp_path / "outside").iterdir())


def test_transitions_are_replaced_as_a_whole(steerable: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Gaits of an earlier run do not stay beside those of the next, also where it is interrupted."""
    place = steerable / FOLDER
    (place / "speed_0.9.json").write_text("{}")
    before = {path.name: path.read_bytes() for path in place.iterdir()}
    with monkeypatch.context() as patch:
        patch.setattr(between, "dumps", lambda *_: 1 / 0)
        with pytest.raises(ZeroDivisionError):
            transitions(steerable, friction=0.6)
    assert {path.name: path.read_bytes() for path in place.iterdir()} == before
    transitions(steerable, friction=0.6)
    assert sorted(path.name for path in place.iterdir()) == ["speed_0.2.json", "speed_0.3.json", HEADER]
    (place / "thesis.tex").touch()
    with pytest.raises(InputError, match=r"'thesis\.tex' in it was not written by this command"):
        transitions(steerable)
