"""A walk in MuJoCo as a trace: states go both ways, forces are those that move the robot, and the page shows it."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiler
from amble.gait import Gait
from amble.gait.files import save_gait
from amble.gait.impedance import Impedance
from amble.robot import kinematics
from amble.validation import BATTERY, Case, CaseResult, validate
from amble.validation.mujoco_model import Plant, mujoco_model, to_mujoco
from amble.validation.walk_trace import from_mujoco
from amble.view import replay
from tests.cli.run import exit_code
from tests.robots import random_states, robot

pytest.importorskip("mujoco")
needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler")


def test_states_go_there_and_back() -> None:
    walker = robot("astro")
    model = mujoco_model(walker, Plant(step=5e-4))
    positions, velocities = random_states(walker, 20)
    positions[:, 4] = np.clip(positions[:, 4], -1.4, 1.4)  # pitch of a quaternion is within a right angle
    for q, v in zip(positions, velocities, strict=True):
        rows = (row[np.newaxis] for row in to_mujoco(walker, model, q, v))
        found = from_mujoco(walker, model, *rows)[0]
        turns = (found[3:6] - q[3:6]) / (2.0 * np.pi)
        np.testing.assert_allclose(turns, np.round(turns), atol=1e-12)
        np.testing.assert_allclose(np.delete(found, [3, 4, 5]), np.delete(np.concatenate([q, v]), [3, 4, 5]), atol=1e-9)


@pytest.fixture(scope="module")
def walked(stabilised_gait: Gait) -> tuple[Gait, tuple[CaseResult, ...]]:
    gait = replace(stabilised_gait, control=Impedance())
    cases = (BATTERY[0], Case(name="ice", friction=0.02))
    return gait, validate(gait, cases=cases, cycles=2, record=True).results


@needs_compiler
def test_forces_are_those_that_move_the_robot(stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch) -> None:
    """Recorded at every step of the plant, the forces' impulse is the momentum of the centre of mass."""
    monkeypatch.setattr("amble.validation.walk_trace.ROWS", 10**6)
    gait = replace(stabilised_gait, control=Impedance())
    trace = validate(gait, cases=BATTERY[:1], cycles=1, record=True).results[0].trace
    assert trace is not None
    walker, time = gait.robot, trace.time
    q, v = ca.SX.sym("q", walker.size), ca.SX.sym("v", walker.size)
    poses = zip(walker.links, kinematics.link_poses(walker, q), strict=True)
    relative = sum(link.mass * (origin + turn @ link.center) for link, (turn, origin) in poses) / walker.mass
    center = ca.jtimes(q[:3] + kinematics.base_rotation(q) @ relative, q, v)
    function = ca.Function("velocity", [q, v], [center]).map(len(time))
    velocity = np.asarray(function(trace.state[:, : walker.size].T, trace.state[:, walker.size :].T))
    force = trace.signals["force"].reshape(len(time), -1, 3).sum(axis=1).T - [[0.0], [0.0], [walker.mass * 9.81]]
    impulse = np.cumsum(force, axis=1) * (time[1] - time[0])
    momentum = walker.mass * (velocity - velocity[:, :1])
    for axis in range(3):
        assert np.corrcoef(impulse[axis], momentum[axis])[0, 1] > 0.99


@needs_compiler
def test_a_walk_is_a_whole_trace(walked: tuple[Gait, tuple[CaseResult, ...]]) -> None:
    gait, results = walked
    trace = results[0].trace
    assert trace is not None
    assert trace.completed
    assert (trace.cycles, trace.section.shape) == (2, (3, 2 * gait.robot.size))
    assert 150 < len(trace.time) < 250


@needs_compiler
def test_a_fall_is_told(walked: tuple[Gait, tuple[CaseResult, ...]]) -> None:
    gait, results = walked
    trace = results[1].trace
    assert trace is not None
    assert trace.completed == (results[1].walk.cycles == 2)
    assert replay(gait, trace).html().count('"poses": "') == 2


@needs_compiler
def test_the_command_records_one_walk_for_a_replay(stabilised_gait: Gait, tmp_path: Path) -> None:
    file = str(save_gait(replace(stabilised_gait, control=Impedance()), tmp_path / "gait.json"))
    trace, out = str(tmp_path / "walk.nc"), ["--out", str(tmp_path / "v.json")]
    assert exit_code("validate", file, "--record", trace, *out) == 2
    assert exit_code("validate", file, "--case", "nominal", "--cycles", "2", "--record", trace, *out) == 0
    assert exit_code("view", file, "--trace", trace, "--html", str(tmp_path / "page.html")) == 0
    assert (tmp_path / "page.html").stat().st_size < 5_000_000
