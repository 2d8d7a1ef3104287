"""MCAP files, read back by the format's own library: every message fits its schema and holds the motion's numbers."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amble.analysis.reference import ReferenceMotion, reference_motion
from amble.analysis.reference_files import write_reference
from amble.errors import MissingExtraError
from amble.gait import Gait
from tests.test_optional import without

TOPICS = {"/tf": "foxglove.FrameTransforms"} | {
    f"/{name.lower()}": f"amble.{name}" for name in ("Joints", "Base", "Feet", "Gait")
}


@pytest.fixture(scope="module")
def motion(walking_gait: Gait) -> ReferenceMotion:
    return reference_motion(walking_gait, 100.0)


@pytest.fixture(scope="module")
def messages(motion: ReferenceMotion, tmp_path_factory: pytest.TempPathFactory) -> dict[str, list[dict[str, Any]]]:
    reader = pytest.importorskip("mcap.reader")
    validator = pytest.importorskip("jsonschema")
    place = write_reference(motion, tmp_path_factory.mktemp("mcap") / "walk.mcap")
    found: dict[str, list[dict[str, Any]]] = {topic: [] for topic in TOPICS}
    with place.open("rb") as stream:
        for schema, channel, message in reader.make_reader(stream).iter_messages():
            assert (schema.name, schema.encoding) == (TOPICS[channel.topic], "jsonschema")
            assert channel.message_encoding == "json"
            assert message.log_time == pytest.approx(1e9 * motion.time[len(found[channel.topic])], abs=0.51)
            content = json.loads(message.data)
            validator.validate(content, json.loads(schema.data))
            found[channel.topic].append(content)
    return found


def test_every_row_is_there_in_every_topic(motion: ReferenceMotion, messages: dict[str, list[dict[str, Any]]]) -> None:
    assert {topic: len(rows) for topic, rows in messages.items()} == dict.fromkeys(TOPICS, len(motion.time))
    assert [row["stance"] for row in messages["/gait"]] == list(motion.stances)


def test_numbers_are_those_of_the_motion(motion: ReferenceMotion, messages: dict[str, list[dict[str, Any]]]) -> None:
    joints = messages["/joints"]
    for key, expected in (("angle", motion.qpos[:, 7:]), ("rate", motion.qvel[:, 6:]), ("torque", motion.torques)):
        assert np.array_equal([[row[key][name] for name in motion.joints] for row in joints], expected)
    base = messages["/base"]
    assert np.array_equal([[row["place"][axis] for axis in "xyz"] for row in base], motion.qpos[:, :3])
    assert np.array_equal([[row["turn"][axis] for axis in "wxyz"] for row in base], motion.qpos[:, 3:7])
    feet = messages["/feet"]
    assert np.array_equal([[row[foot]["stands"] for foot in motion.feet] for row in feet], motion.contacts)
    forces = [[[row[foot]["force"][axis] for axis in "xyz"] for foot in motion.feet] for row in feet]
    assert np.array_equal(forces, motion.forces)


def test_frames_are_the_links_in_the_world(motion: ReferenceMotion, messages: dict[str, list[dict[str, Any]]]) -> None:
    for row, message in enumerate(messages["/tf"]):
        links = message["transforms"]
        assert [link["child_frame_id"] for link in links] == list(motion.bodies)
        assert {link["parent_frame_id"] for link in links} == {"world"}
        assert np.array_equal([[link["translation"][a] for a in "xyz"] for link in links], motion.body_positions[row])
        assert np.array_equal([[link["rotation"][a] for a in "wxyz"] for link in links], motion.body_quaternions[row])
        stamp = links[0]["timestamp"]
        assert stamp["sec"] + 1e-9 * stamp["nsec"] == pytest.approx(motion.time[row], abs=1e-9)


def test_without_the_library_the_extra_is_named(
    motion: ReferenceMotion, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    without(monkeypatch, "mcap")
    with pytest.raises(MissingExtraError, match="mcap"):
        write_reference(motion, tmp_path / "walk.mcap")
