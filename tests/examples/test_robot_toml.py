"""The example of a robot format: the same robot by TOML and by URDF, and its refusals in one sentence."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from examples.extending import robot_toml  # its import registers the format

from amble.errors import InputError, UnknownNameError
from amble.robot import READERS, Robot, load_robot
from amble.synthesis.specification import read_specification
from amble.synthesis.specified import problem_of

LEGS = {"fl": (0.2, 0.1), "fr": (0.2, -0.1), "rl": (-0.2, 0.1), "rr": (-0.2, -0.1)}
FEET = {leg: f"{leg}_foot" for leg in LEGS}


def toml() -> str:
    parts = ['name = "quadruped"', "[links.trunk]", "mass = 6.0", "inertia = [0.02, 0.05, 0.06]"]
    for leg in LEGS:
        for part, mass in (("hip", 0.5), ("thigh", 0.4), ("shank", 0.2)):
            parts += [f"[links.{leg}_{part}]", f"mass = {mass}"]
            parts += [
                "center = [0.0, 0.0, -0.08]",
                "inertia = [2e-3, 3e-3, 1e-3]",
            ]
        parts.append(f"[links.{leg}_foot]")
    for leg, (x, y) in LEGS.items():
        for name, parent, child, at, axis in joints(leg, x, y):
            turns = [] if axis is None else [f"axis = {axis}", "range = [-2.0, 2.0]", "torque = 20", "speed = 12"]
            parts += [f"[joints.{name}]", f'parent = "{parent}"', f'child = "{child}"', f"at = {at}", *turns]
    return "\n".join(parts)


def joints(leg: str, x: float, y: float) -> list[tuple[str, str, str, list[float], list[float] | None]]:
    return [
        (f"{leg}_roll", "trunk", f"{leg}_hip", [x, y, 0.0], [2.0, 0.0, 0.0]),
        (f"{leg}_pitch", f"{leg}_hip", f"{leg}_thigh", [0.0, 0.0, -0.02], [0.0, 1.0, 0.0]),
        (f"{leg}_knee", f"{leg}_thigh", f"{leg}_shank", [0.0, 0.0, -0.2], [0.0, 1.0, 0.0]),
        (f"{leg}_ankle", f"{leg}_shank", f"{leg}_foot", [0.0, 0.0, -0.2], None),
    ]


def urdf() -> str:
    def link(name: str, mass: float, z: float, moments: tuple[float, float, float]) -> str:
        x, y, w = moments
        return (
            f'<link name="{name}"><inertial><origin xyz="0 0 {z}"/><mass value="{mass}"/>'
            f'<inertia ixx="{x}" iyy="{y}" izz="{w}" ixy="0" ixz="0" iyz="0"/></inertial></link>'
        )

    parts = ['<robot name="quadruped">', link("trunk", 6.0, 0.0, (0.02, 0.05, 0.06))]
    for leg in LEGS:
        masses = (("hip", 0.5), ("thigh", 0.4), ("shank", 0.2))
        parts += [link(f"{leg}_{part}", mass, -0.08, (2e-3, 3e-3, 1e-3)) for part, mass in masses]
        parts.append(f'<link name="{leg}_foot"/>')
    for leg, (x, y) in LEGS.items():
        for name, parent, child, at, axis in joints(leg, x, y):
            place = f'<origin xyz="{" ".join(map(str, at))}"/><parent link="{parent}"/><child link="{child}"/>'
            turns = "" if axis is None else f'<axis xyz="{" ".join(map(str, axis))}"/>'
            limits = "" if axis is None else '<limit lower="-2" upper="2" effort="20" velocity="12"/>'
            kind = "fixed" if axis is None else "revolute"
            parts.append(f'<joint name="{name}" type="{kind}">{place}{turns}{limits}</joint>')
    return "".join([*parts, "</robot>"])


@pytest.fixture
def both(tmp_path: Path) -> tuple[Robot, Robot]:
    (tmp_path / "robot.toml").write_text(toml())
    (tmp_path / "robot.urdf").write_text(urdf())
    return load_robot(tmp_path / "robot.toml", FEET), load_robot(tmp_path / "robot.urdf", FEET)


def test_the_same_robot_comes_from_both_formats(both: tuple[Robot, Robot]) -> None:
    ours, theirs = both
    assert ours.source == "robot.toml"
    assert replace(ours, source=theirs.source) == theirs
    assert len(ours.joints) == 12
    np.testing.assert_allclose(ours.mass, 6.0 + 4 * 1.1)


def test_the_format_may_be_named(tmp_path: Path, both: tuple[Robot, Robot]) -> None:
    (tmp_path / "robot.txt").write_text(toml())
    found = load_robot(tmp_path / "robot.txt", FEET, format="toml")
    assert replace(found, source="robot.toml") == both[0]
    with pytest.raises(InputError, match=r"'.*robot.txt' is not well-formed XML"):  # nothing says that it is no URDF
        load_robot(tmp_path / "robot.txt", FEET)
    with pytest.raises(UnknownNameError, match="unknown format of robot files 'sdf'; known: urdf, mjcf, xml, toml"):
        load_robot(tmp_path / "robot.toml", FEET, format="sdf")


def test_a_specification_names_the_file(tmp_path: Path, both: tuple[Robot, Robot]) -> None:
    angles = "\n".join(
        f"{leg}_{joint} = {angle}" for leg in LEGS for joint, angle in (("roll", 0), ("pitch", 0.6), ("knee", -1.2))
    )
    feet = "\n".join(f'{label} = "{frame}"' for label, frame in FEET.items())
    (tmp_path / "spec.toml").write_text(
        f'[robot]\nfile = "robot.toml"\n[robot.feet]\n{feet}\n[gait]\nname = "trot"\nspeed = 0.2\n'
        "[limits]\nclearance = 0.02\nnormal_force = 5\nduration = [0.1, 0.4]\nacceleration = 200\n"
        "[limits.touchdown_velocity]\nx = [-1, 1]\ny = [-1, 1]\nz = [-1, -0.1]\n"
        f"[posture]\nheight = 0.36\n[posture.angles]\n{angles}\n"
    )
    problem = problem_of(read_specification(tmp_path / "spec.toml"), tmp_path)
    assert problem.pattern.robot == both[0]


@pytest.mark.parametrize(
    ("before", "after", "sentence"),
    [
        (
            "mass = 6.0",
            "weight = 6.0",
            "unknown key of robot.toml, link 'trunk' 'weight'; known: mass, c",
        ),
        ("mass = 6.0", 'mass = "6"', "robot.toml, link 'trunk': 'mass' is not 1 number"),
        ("mass = 6.0", "mass = nan", "the mass of link 'trunk' is nan, not a finite number"),
        ("inertia = [0.02, 0.05, 0.06]", "inertia = [0.02, 0.05]", "'inertia' is not 3 numbers"),
        ("axis = [0.0, 1.0, 0.0]", "axis = [0.0, 0.0, 0.0]", "has an axis of length zero"),
        ('parent = "fl_hip"', 'parent = "fl_hep"', "unknown link .joint 'fl_pitch' of robot.toml. 'fl_hep'"),
        ('name = "quadruped"', "links = 3", "not well-formed|is not a table|is not TOML"),
    ],
)
def test_what_is_wrong_is_said(before: str, after: str, sentence: str, tmp_path: Path) -> None:
    assert before in toml()
    (tmp_path / "robot.toml").write_text(toml().replace(before, after, 1))
    with pytest.raises(InputError, match=sentence):
        load_robot(tmp_path / "robot.toml", FEET)


def test_a_name_is_registered_once() -> None:
    READERS.register("toml", robot_toml.read_robot_toml)
    with pytest.raises(InputError, match="another format of robot files of the name 'urdf'"):
        READERS.register("urdf", robot_toml.read_robot_toml)
