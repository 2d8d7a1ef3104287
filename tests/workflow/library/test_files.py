"""The folder of a library: records last, tables of everything, nothing of others overwritten."""

from __future__ import annotations

import csv
import json
from dataclasses import replace
from pathlib import Path

import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import content_hash, save_gait
from amble.workflow.library.axes import read_library
from amble.workflow.library.entry import Made
from amble.workflow.library.files import (
    CERTIFICATES,
    FAILED,
    GAITS,
    Library,
    claim_folder,
    load_library,
    read_entry,
    write_entry,
    write_tables,
)
from amble.workflow.library.maps import write_maps
from amble.workflow.library.numbers import gait_numbers
from tests.workflow.library.test_axes import written


@pytest.fixture
def folder(tmp_path: Path) -> Path:
    library = read_library(written(tmp_path, "speed = { range = [0.1, 0.3], step = 0.1 }"))
    claim_folder(tmp_path / "library", library)
    return tmp_path / "library"


def test_a_failure_keeps_its_gait_and_its_reason(folder: Path, stabilised_gait: Gait) -> None:
    made = Made(stage="check", reason="a row fails\nby much", gait=stabilised_gait, numbers={"radius": 0.5})
    made.seconds["solve"], made.notes[:] = 1.25, ["odd"]
    write_entry(folder, {"speed": 0.1}, "speed_0.2", made)
    found = load_library(folder)
    assert not found.certified
    (entry,) = found.failures
    assert entry == read_entry(folder, {"speed": 0.1})
    assert (entry.stage, entry.start, entry.notes) == ("check", "speed_0.2", ("odd",))
    assert entry.file == f"{FAILED}/speed_0.1.json"
    assert found.gait(entry).period == stabilised_gait.period
    index, failures = write_tables(found)
    (row,) = csv.DictReader(failures.read_text().splitlines())
    assert row["speed (m/s)"] == "0.1"
    assert row["reason"] == "a row fails by much"
    assert row["solve_processor_s"] == "1.25"
    assert not index.read_text().strip()


def test_a_gait_that_was_changed_after_it_was_made_is_refused(folder: Path, stabilised_gait: Gait) -> None:
    """Another sound gait in its place is a gait file as any other: only the hash tells."""
    entry = write_entry(folder, {"speed": 0.1}, None, Made(stage="check", reason="no", gait=stabilised_gait))
    assert entry.hash == content_hash(stabilised_gait)
    assert entry.file is not None
    save_gait(replace(stabilised_gait, speed=0.21), folder / entry.file)
    with pytest.raises(InputError, match="changed after it was made") as refused:
        load_library(folder).gait(entry)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("told", [{"content_hash": "0" * 64}, {}, [1], None])
def test_a_certificate_of_another_gait_is_refused(folder: Path, stabilised_gait: Gait, told: object) -> None:
    made = Made(stage="check", reason="no", gait=stabilised_gait)
    entry = write_entry(folder, {"speed": 0.1}, None, made)
    certificate = folder / CERTIFICATES / "speed_0.1.json"
    certificate.parent.mkdir()
    certified = replace(entry, certified=True)
    certificate.write_text(json.dumps({"gait": {"content_hash": entry.hash}}))
    assert load_library(folder).gait(certified).period == stabilised_gait.period
    certificate.write_text(json.dumps({"gait": told}))
    with pytest.raises(InputError, match="not the gait that its certificate tells of"):
        load_library(folder).gait(certified)


def test_a_gait_that_was_not_solved_has_no_file(folder: Path) -> None:
    entry = write_entry(folder, {"speed": 0.1}, None, Made(stage="solve", reason="it took more than 1 s"))
    assert entry.file is None
    with pytest.raises(InputError, match=r"no gait at speed_0\.1: it took more than 1 s"):
        load_library(folder).gait(entry)


def test_tried_again_the_failed_gait_is_gone(folder: Path, stabilised_gait: Gait) -> None:
    write_entry(folder, {"speed": 0.1}, None, Made(stage="check", reason="no", gait=stabilised_gait))
    write_entry(folder, {"speed": 0.1}, None, Made(stage="check", reason="still no", gait=stabilised_gait))
    assert [path.name for path in (folder / FAILED).iterdir()] == ["speed_0.1.json"]
    assert not (folder / GAITS).exists()


def test_another_specification_is_refused_and_other_axes_values_are_not(tmp_path: Path, folder: Path) -> None:
    claim_folder(folder, read_library(written(tmp_path, "speed = { range = [0.1, 0.4], step = 0.05 }")))
    other = read_library(written(tmp_path, "speed = { range = [0.1, 0.3], step = 0.1 }", "[ground]\nfriction = 0.7"))
    with pytest.raises(InputError, match="another specification"):
        claim_folder(folder, other)
    with pytest.raises(InputError, match="another specification"):
        claim_folder(folder, read_library(written(tmp_path, "height = { range = [0.34, 0.36], step = 0.01 }")))
    (tmp_path / "work").mkdir()
    (tmp_path / "work" / "thesis.tex").touch()
    with pytest.raises(InputError, match="no library"):
        claim_folder(tmp_path / "work", other)
    with pytest.raises(InputError, match="not a folder"):
        claim_folder(tmp_path / "work" / "thesis.tex", other)


@pytest.mark.parametrize("text", ["{}", '{"values": {}}', "[1]", '{"values": {}, "colour": 1, "notes": []}'])
def test_a_damaged_record_is_a_sentence(folder: Path, text: str) -> None:
    (folder / "records").mkdir()
    (folder / "records" / "speed_0.1.json").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match="record"):
        load_library(folder)


def test_no_library(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="library"):
        load_library(tmp_path)
    (tmp_path / "library.json").write_text(json.dumps({"format": "amble gait"}), encoding="utf-8")
    with pytest.raises(InputError, match="no library"):
        load_library(tmp_path)


def test_numbers_are_those_of_the_gait(stabilised_gait: Gait) -> None:
    """Cost of transport, peak and RMS torque of the paper's amble as `make run` states them for the pseudo-inverse."""
    found = gait_numbers(stabilised_gait)
    assert found["distance_m"] == pytest.approx(stabilised_gait.speed * stabilised_gait.period, rel=1e-6)
    joints = len(stabilised_gait.robot.joints)
    assert found["rms_torque_N_m"] ** 2 * joints == pytest.approx(found["objective"], rel=2e-3)
    assert found["least_height_m"] < found["mean_height_m"] < found["largest_height_m"]
    assert found["cost_of_transport_datasheet"] < found["cost_of_transport_paper"]


def test_every_number_of_a_gait_is_read_back(folder: Path, stabilised_gait: Gait) -> None:
    """The names that amble gives its numbers are names to its own reader."""
    made = Made(stage="check", reason="no", gait=stabilised_gait, numbers=gait_numbers(stabilised_gait))
    entry = write_entry(folder, {"speed": 0.1}, None, made)
    assert read_entry(folder, {"speed": 0.1}) == entry
    assert entry.numbers["rms_torque_N_m"] > 0


def test_maps_are_drawn_of_what_is_certified(folder: Path, unrendered: None) -> None:
    del unrendered
    write_entry(folder, {"speed": 0.1}, None, Made(stage="solve", reason="no"))
    library = load_library(folder)
    assert write_maps(library) == ()
    (failed,) = library.entries
    numbers = {"radius": 0.5, "cost_of_transport_x": 1.0, "returns_from": "words, as a record from elsewhere may say"}
    certified = replace(failed, values={"speed": 0.2}, certified=True, numbers=numbers)
    names = [path.name for path in write_maps(Library(folder, (failed, certified)))]
    assert names == [
        f"map-{key}.{kind}" for key in ("cost_of_transport_x", "radius", "returns_from") for kind in ("png", "pdf")
    ]


FORGED: dict[str, dict[str, object]] = {
    "certified without a gait": {"certified": True, "file": None},
    "certified without its files": {"certified": True, "file": "gaits/speed_0.1.json"},
    "certified in words": {"certified": "no"},
    "of another gait": {"values": {"speed": 9.0}},
    "values in words": {"values": {"speed": "abc"}},
    "values of nothing": {"values": [1]},
    "an axis that is none": {"values": {"nope": 1.0}},
    "a file elsewhere": {"file": "../../../etc/passwd"},
    "a number's name that leaves the folder": {"numbers": {"cost/../../escaped": 1.0}},
    "numbers in words": {"numbers": "x"},
    "not finite": {"numbers": {"radius": float("inf")}},
    "seconds in words": {"seconds": {"solve": "x"}},
    "a reason that is a number": {"reason": 3},
    "a content without a gait": {"hash": "0" * 64},
    "a content that is no text": {"hash": 1},
    "a number of 400 digits": {"numbers": {"radius": 10**400}},
    "lists of lists": {"numbers": {"radius": [[[]]]}},
    "a number in a list that is none": {"numbers": {"radius": [float("nan")]}},
    "a stage that there is not": {"stage": "\x1b[31m"},
    "far more than a record": {"notes": [""] * 400_000},
}


@pytest.mark.parametrize("name", FORGED)
def test_a_forged_record_is_refused(name: str, folder: Path) -> None:
    write_entry(folder, {"speed": 0.1}, None, Made(stage="solve", reason="it took more than 1 s"))
    record = folder / "records" / "speed_0.1.json"
    record.write_text(json.dumps({**json.loads(record.read_text()), **FORGED[name]}))
    with pytest.raises(InputError) as refused:
        load_library(folder)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("name", ["gaits", "failed", "records", "certificates", "index.csv", "failures.csv"])
def test_a_link_in_a_library_is_not_followed(name: str, tmp_path: Path, stabilised_gait: Gait) -> None:
    library = read_library(written(tmp_path, "speed = { range = [0.1, 0.3], step = 0.1 }"))
    folder, outside = tmp_path / "library", tmp_path / "outside"
    claim_folder(folder, library)
    outside.mkdir()
    (outside / "speed_0.1.json").write_text("mine")
    (folder / name).symlink_to(outside / "new.csv" if name.endswith("csv") else outside)
    with pytest.raises(InputError, match="leads out of it"):
        claim_folder(folder, library)
    if name in ("gaits", "failed", "records"):
        with pytest.raises(InputError, match="leads out of it"):
            write_entry(folder, {"speed": 0.1}, None, Made(stage="check", reason="no", gait=stabilised_gait))
    assert [path.read_text() for path in outside.iterdir()] == ["mine"]
