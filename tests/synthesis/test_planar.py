"""A five-link biped in the plane of x and z, from its URDF to a certified walk."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from amble.analysis import monitors
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.codec import GAIT
from amble.gait.files import load_gait, save_gait
from amble.robot.natural_units import natural_units
from amble.simulation import simulate
from amble.simulation.simulate import perturbed
from amble.stability import certify
from amble.stability.stabilize import stabilize
from amble.synthesis import gait_problem, synthesize
from amble.validation.battery import validate
from amble.verification.check import check
from tests.robots import PLANAR, robot


@lru_cache(maxsize=1)
def walk() -> Gait:
    return synthesize(gait_problem(robot(PLANAR), "walk", speed=0.5))


def test_a_walk_is_solved_checked_and_kept(tmp_path: Path) -> None:
    gait = walk()
    assert gait.pattern.contact.name == "planar point"
    assert gait.pattern.mirrored
    assert [name for name in gait.limits.positions if name not in gait.robot.joint_names] == ["z", "pitch"]
    assert gait.domains[0].forces.shape == (31, 2)
    assert gait.domains[0].coefficients.shape == (4, 5)
    report = check(gait)
    assert report.passed, report.failed
    assert not [row.name for row in report.rows if "roll" in row.name or "yaw" in row.name]
    file = tmp_path / "walk.json"
    save_gait(gait, file)
    assert GAIT.encode(load_gait(file), "walk") == GAIT.encode(gait, "walk")


def test_the_check_sees_a_force_that_is_not_there() -> None:
    gait = walk()
    first = gait.domains[0]
    pushed = replace(first, forces=first.forces + np.array([0.1, 0.0]))
    assert {row.kind for row in check(replace(gait, domains=(pushed,))).failed} == {"dynamics", "force"}


def test_mujoco_walks_robots_in_space() -> None:
    with pytest.raises(InputError, match="MuJoCo walks robots in space"):
        validate(walk())


@pytest.mark.slow
@pytest.mark.parametrize(("name", "speed"), [("walk", 0.3), ("walk", 0.6), ("run", 0.6)])
def test_walk_and_run_are_certified_and_go_on(name: str, speed: float) -> None:
    """From a start in which every state is changed by 1e-3 in natural units.

    Of the walk the price of ill-conditioned outputs, at its default, keeps the descent at a radius of 1.03.
    """
    gait = synthesize(gait_problem(robot(PLANAR), name, speed=speed))
    assert check(gait).passed
    stable = stabilize(gait)
    certificate = certify(stable)
    assert certificate.radius < 1.0
    units = natural_units(gait.robot, gait.robot.leg_length)
    trace = simulate(stable, certificate.state + units * perturbed(np.zeros(units.size), 1e-3, 0), 500)
    assert trace.completed, trace.ended
    assert monitors(stable, trace).sound_from is not None
