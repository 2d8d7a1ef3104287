"""The same at every size: similar robots take the same iterations to the same optimum, in their own units."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from amble.robot import Robot, load_robot
from amble.synthesis import gait_problem, synthesize
from tests.quadruped import FEET, urdf
from tests.similar import similar_robot

EXACT = [(4.0**-3, 2.0**-13), (4.0**2, 2.0**7)]
"""Factors of lengths and masses that change no digit: from about 1 g to 1,400 kg."""

ANY = [(0.3, 0.011), (2.7, 31.0)]


@pytest.fixture(scope="module")
def quadruped(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """11 kg with legs of 0.4 m."""
    path: Path = tmp_path_factory.mktemp("robot") / "padda.urdf"
    path.write_text(urdf())
    return load_robot(path, FEET)


@pytest.fixture(autouse=True)
def interpreted(monkeypatch: pytest.MonkeyPatch) -> None:
    """Every size is code of its own; compiling it takes longer than the little that is run of it."""
    monkeypatch.setenv("AMBLE_COMPILER", "none")


def solved(robot: Robot, gait: str, intervals: int) -> tuple[int, float, float]:
    """Iterations, violation of the scaled problem, and the optimum in units of (m g l)^2, of the default problem."""
    weight = robot.mass * robot.gravity * robot.leg_length
    problem = gait_problem(robot, gait, speed=0.15 * np.sqrt(robot.gravity * robot.leg_length), intervals=intervals)
    report = synthesize(problem).solver
    return report.iterations, report.violation, report.objective / weight**2


def test_similar_robots_walk_alike(quadruped: Robot) -> None:
    """Iterations and every digit of the optimum where factors are powers of two; close to that where they are not."""
    iterations, violation, optimum = solved(quadruped, "trot", 2)
    length, mass = EXACT[0]
    assert solved(similar_robot(quadruped, mass, length), "trot", 2) == (iterations, violation, optimum)
    length, mass = ANY[0]
    count, _, value = solved(similar_robot(quadruped, mass, length), "trot", 2)
    assert abs(count - iterations) <= 2
    assert value == pytest.approx(optimum, rel=1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("gait", ["trot", "amble", "bound"])
def test_similar_robots_walk_alike_on_meshes_of_use(quadruped: Robot, gait: str) -> None:
    """The same with more intervals, from 1 g to 1,000 kg."""
    iterations, violation, optimum = solved(quadruped, gait, 8)
    for length, mass in EXACT:
        assert solved(similar_robot(quadruped, mass, length), gait, 8) == (iterations, violation, optimum)
    for length, mass in ANY:
        count, _, value = solved(similar_robot(quadruped, mass, length), gait, 8)
        assert abs(count - iterations) <= 2
        assert value == pytest.approx(optimum, rel=1e-8)
