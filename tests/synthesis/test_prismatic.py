"""A quadruped on telescopic legs: its gait in N and m, the same at every size, checked, stabilised and walked."""

from __future__ import annotations

import re
import subprocess
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import amble
from amble.codegen import compiler
from amble.errors import InputError
from amble.export import export_controller
from amble.gait import Gait
from amble.gait.files import load_gait, save_gait, to_dict
from amble.gait.impedance import Impedance
from amble.gait.motion_files import read_motion, recorded_gait, write_motion
from amble.robot import Robot
from amble.synthesis import gait_problem, synthesize
from amble.synthesis.specification import specification_of
from amble.synthesis.specified import problem_of
from tests.similar import similar_robot
from tests.sliding import FEET, telescopic, telescopic_urdf

SLIDES = [2, 5, 8, 11]


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every robot is code of its own; compiling it takes longer than the little that is run of it."""
    monkeypatch.setenv("AMBLE_COMPILER", "none")


def solved(robot: Robot, intervals: int = 2) -> Gait:
    speed = 0.15 * np.sqrt(robot.gravity * robot.leg_length)
    return synthesize(gait_problem(robot, "pronk", speed=speed, intervals=intervals))


@pytest.fixture(scope="module")
def gait() -> Gait:
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")
        return solved(telescopic())


def test_forces_cost_what_they_would_at_the_leg_length(gait: Gait, tmp_path: Path) -> None:
    """The mean of the squares by the scheme's own quadrature, Simpson's rule; a file in N and m comes back equal."""
    robot, simpson = gait.robot, np.array([1.0, 4.0, 2.0, 4.0, 1.0]) / 12.0
    arms = np.where(np.isin(range(12), SLIDES), robot.leg_length, 1.0)
    work = sum(part.duration * simpson @ np.sum((part.torques * arms) ** 2, axis=1) for part in gait.domains)
    assert work / sum(part.duration for part in gait.domains) == pytest.approx(gait.solver.objective, rel=1e-9)
    most = max(np.abs(part.torques[:, SLIDES]).max() for part in gait.domains)
    assert most > 0.2 * robot.mass * robot.gravity  # the legs carry the robot
    assert gait.limits.accelerations(robot)["fl_slide"] == pytest.approx(18.0 * robot.gravity)
    assert "largest force of a joint" in gait._repr_html_()
    save_gait(gait, tmp_path / "gait.json")
    save_gait(load_gait(tmp_path / "gait.json"), tmp_path / "again.json")
    entry = (tmp_path / "gait.json").read_text()
    assert (tmp_path / "again.json").read_text() == entry
    assert '"N m", "N m", "N"' in entry
    turned = re.sub(r'"kind": "prismatic",\s*', "", entry, count=1)
    (tmp_path / "turned.json").write_text(turned)
    with pytest.raises(InputError, match="range has the unit 'm', not 'rad'"):
        load_gait(tmp_path / "turned.json")


@pytest.mark.slow
def test_similar_robots_walk_alike(gait: Gait) -> None:
    """The same iterations to rounding where factors are powers of two; close to that where they are not."""
    unit = (gait.robot.mass * gait.robot.gravity * gait.robot.leg_length) ** 2
    for length, mass, exact in ((4.0**-3, 2.0**-13, True), (4.0**2, 2.0**7, True), (2.7, 31.0, False)):
        other = solved(similar_robot(gait.robot, mass, length))
        found = other.solver.objective / (other.robot.mass * other.robot.gravity * other.robot.leg_length) ** 2
        assert found == pytest.approx(gait.solver.objective / unit, rel=1e-13 if exact else 1e-8, abs=0.0)
        assert abs(other.solver.iterations - gait.solver.iterations) <= (0 if exact else 2)


def specified(limits: dict[str, Any], folder: Path, robot: dict[str, Any] | None = None) -> Any:
    (folder / "telescopic.urdf").write_text(telescopic_urdf())
    section = {"file": "telescopic.urdf", "feet": FEET, **(robot or {})}
    tree = {"robot": section, "gait": {"name": "trot", "speed": 0.3}, "limits": limits}
    return problem_of(specification_of(tree, "trot.toml"), folder)


def test_limits_have_the_units_of_their_joints(tmp_path: Path) -> None:
    limits = specified(
        {
            "joints": {"fl_slide": ["20 mm", "0.15 m"], "fl_roll": ["-30 deg", 0.5]},
            "torque": "20 N m",
            "torques": {"fl_slide": "0.1 kN"},
            "speeds": {"fl_slide": "80 cm/s"},
            "motors": {"fl_slide": {"stall_torque": "120 N", "no_load_speed": "3 m/s"}},
        },
        tmp_path,
    ).limits
    assert limits.positions["fl_slide"] == (0.02, 0.15)
    assert (limits.torques["fl_slide"], limits.torques["fr_slide"], limits.torques["fr_roll"]) == (100.0, 150.0, 20.0)
    assert limits.speeds["fl_slide"] == pytest.approx(0.8)
    assert (limits.motors["fl_slide"].stall_torque, limits.motors["fl_slide"].no_load_speed) == (120.0, 3.0)


@pytest.mark.parametrize(
    ("limits", "robot", "says"),
    [
        ({"joints": {"fl_slide": ["2 deg", 0.15]}}, {}, "range of 'fl_slide' has a unit for a quantity of angle"),
        (
            {"torques": {"fl_roll": "20 N"}},
            {},
            r"torque limit of 'fl_roll' .* of force; it is one of torque \(N m,",
        ),
        ({"motor": {"stall_torque": "9 N", "no_load_speed": 3.0}}, {}, "stall_torque of the motor has a unit .* force"),
        ({}, {"locked": {"fl_slide": "3 deg"}}, "locked joint 'fl_slide' has a unit for a quantity of angle"),
        ({}, {"dampings": {"fl_slide": "3 N m s/rad"}}, "damping of 'fl_slide' .*; it is one of linear damping"),
        ({}, {"rotor_inertias": {"fl_roll": "3 kg"}}, "rotor_inertia of 'fl_roll' .* of mass; it is one of inertia"),
    ],
)
def test_units_of_the_other_kind_are_refused(
    limits: dict[str, Any], robot: dict[str, Any], says: str, tmp_path: Path
) -> None:
    with pytest.raises(InputError, match=says):
        specified(limits, tmp_path, robot)


@pytest.mark.parametrize("suffix", [".npz", ".csv", ".mat"])
def test_a_motion_comes_back_equal(suffix: str, gait: Gait, tmp_path: Path) -> None:
    found = recorded_gait(read_motion(write_motion(gait, tmp_path / f"gait{suffix}")))
    assert to_dict(found) == to_dict(gait)


@pytest.mark.slow
def test_a_walk_on_telescopic_legs_is_certified_and_goes_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("AMBLE_COMPILER")
    found = synthesize(gait_problem(telescopic(), "walk", speed=0.2, intervals=12))
    assert amble.check(found).passed
    stable = amble.stabilize(found)
    assert amble.check(stable).passed
    certificate = amble.certify(stable)  # raises where it cannot speak for the gait
    assert certificate.radius < 0.95
    trace = amble.simulate(stable, certificate.state, 500)
    assert trace.completed, trace.ended
    for number, control in enumerate((stable.control, Impedance())):
        walking = replace(stable, control=control)
        written = export_controller(walking, None, tmp_path / str(number))
        tool = compiler()
        assert tool is not None
        names = [path.name for path in (*written.sources, written.folder / "replay.c")]
        subprocess.run([tool.path, "-std=c99", "-O0", "-o", "replay", *names, "-lm"], cwd=written.folder, check=True)
        done = subprocess.run(
            ["./replay", "test_vectors.txt"], cwd=written.folder, capture_output=True, text=True, check=False
        )
        assert done.returncode == 0, done.stderr  # stances that lift-offs end were played beyond their end
