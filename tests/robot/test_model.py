"""The record: names, chains, and a hash that changes with what matters and with nothing else."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import FrozenInstanceError, replace

import numpy as np
import pytest

from amble.errors import UnknownNameError
from amble.robot import Robot, catalogue, kinematics, load_robot
from amble.types import frozen
from tests.robots import ROBOTS, path, robot


def change_joint(model: Robot, **changes: object) -> Robot:
    return replace(model, joints=(replace(model.joints[0], **changes), *model.joints[1:]))


def change_link(model: Robot, **changes: object) -> Robot:
    return replace(model, links=(replace(model.links[0], **changes), *model.links[1:]))


SMALL = 1e-15

CHANGES: dict[str, Callable[[Robot], Robot]] = {
    "mass": lambda m: change_link(m, mass=m.links[0].mass * (1 + SMALL)),
    "center": lambda m: change_link(m, center=frozen(m.links[0].center + SMALL)),
    "inertia": lambda m: change_link(m, inertia=frozen(m.links[0].inertia * (1 + SMALL))),
    "link name": lambda m: change_link(m, name="trunk"),
    "translation": lambda m: change_joint(m, translation=frozen(m.joints[0].translation + SMALL)),
    "rotation": lambda m: change_joint(m, rotation=frozen(m.joints[0].rotation @ np.diag([-1.0, -1.0, 1.0]))),
    "axis": lambda m: change_joint(m, axis=frozen(-m.joints[0].axis)),
    "joint name": lambda m: change_joint(m, name="other"),
    "lower": lambda m: change_joint(m, lower=-2.0),
    "upper": lambda m: change_joint(m, upper=2.0),
    "effort": lambda m: change_joint(m, effort=1.0),
    "velocity": lambda m: change_joint(m, velocity=1.0),
    "gravity": lambda m: replace(m, gravity=9.80665),
    "twins": lambda m: replace(m, twins=m.twins[:1]),
    "symmetry tolerance": lambda m: replace(m, symmetry_tolerance=1e-8),
    "foot order": lambda m: replace(m, feet=m.feet[::-1]),
    "foot label": lambda m: replace(m, feet=(replace(m.feet[0], name="left"), *m.feet[1:]), twins=()),
    "foot offset": lambda m: replace(m, feet=(replace(m.feet[0], offset=frozen([0.0, 0.0, 0.0])), *m.feet[1:])),
}


@pytest.mark.parametrize("what", CHANGES)
def test_hash_changes_with_what_matters(what: str) -> None:
    model = robot("astro")
    changed = CHANGES[what](model)
    assert changed.hash != model.hash
    assert changed != model


def test_hash_keeps_when_only_names_of_the_file_change() -> None:
    model = robot("astro")
    renamed = replace(model, name="another", source="elsewhere.urdf")
    assert renamed.hash == model.hash
    assert renamed == model
    assert hash(renamed) == hash(model)


def test_hash_is_the_same_in_another_process() -> None:
    code = "from amble.robot import catalogue; print(catalogue.astro().hash)"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == robot("astro").hash
    assert len(robot("astro").hash) == 64


def test_records_are_frozen_to_the_array() -> None:
    model = catalogue.astro()
    with pytest.raises(FrozenInstanceError):
        model.gravity = 1.0  # type: ignore[misc]
    for array in (model.links[0].inertia, model.joints[0].axis, model.feet[0].offset):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 1.0


@pytest.mark.parametrize("name", ROBOTS)
def test_joints_keep_the_order_of_the_file(name: str) -> None:
    text = path(name).read_text()
    model = robot(name)
    positions = [text.index(f'name="{joint}"') for joint in model.joint_names]
    assert positions == sorted(positions)
    assert len(model.joints) == 12
    assert model.coordinate_names[:6] == ("x", "y", "z", "roll", "pitch", "yaw")
    assert model.coordinate_names[6:] == model.joint_names
    assert model.size == 18
    assert [joint.child for joint in model.joints] == list(range(1, 13))


@pytest.mark.parametrize("name", ROBOTS)
def test_legs_are_chains_of_three_joints(name: str) -> None:
    model = robot(name)
    assert tuple(model.legs) == model.foot_names
    seen = [joint for joints in model.legs.values() for joint in joints]
    assert sorted(seen) == sorted(model.joint_names)
    for joints in model.legs.values():
        parents = [model.joint(joint).parent for joint in joints]
        assert parents == [0, *(model.joint(joint).child for joint in joints[:-1])]


def test_foot_order_is_the_users() -> None:
    feet = {"rr": "rr_foot", "fl": "fl_foot"}
    assert load_robot(path("astro"), feet).foot_names == ("rr", "fl")


def test_look_ups_name_what_exists() -> None:
    model = robot("astro")
    assert model.joint_index("rr_knee") == 11
    assert model.coordinate_index("rr_knee") == 17
    assert model.coordinate_index("yaw") == 5
    with pytest.raises(UnknownNameError, match="unknown joint 'knee'; known: fl_hip_yaw, "):
        model.joint("knee")
    with pytest.raises(UnknownNameError, match="unknown coordinate 'w'; known: x, y, z, roll"):
        model.coordinate_index("w")
    with pytest.raises(UnknownNameError, match="unknown foot 'tail'; known: fl, rl, fr, rr"):
        model.foot("tail")


def test_total_mass() -> None:
    assert robot("astro").mass == pytest.approx(10.1 + 4 * (1.18 + 1.39 + 0.28), rel=1e-14)


def test_the_leg_length_is_that_of_the_longest_stretched_leg() -> None:
    """Longer than any distance from hip to foot that a pose can make, and reached by some pose."""
    model = robot("astro")
    generator = np.random.default_rng(0)
    reached = 0.0
    for pose in generator.uniform(-np.pi, np.pi, (2000, model.size)):
        pose[:6] = 0.0
        for foot in model.feet:
            place = np.asarray(kinematics.foot_position(model, foot.name, pose)).ravel()
            reached = max(reached, float(np.linalg.norm(place)))
    assert reached <= model.leg_length
    assert reached >= 0.8 * model.leg_length
