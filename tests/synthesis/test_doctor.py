"""A problem that cannot have a solution is refused in a sentence; an iteration would take a thousand rows to say it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from amble.errors import InputError
from amble.hybrid import Plane
from amble.robot import catalogue
from amble.robot.catalogue import Posture
from amble.synthesis import GaitProblem, gait_problem, synthesize
from amble.synthesis.doctor import require_possible
from tests.robots import ROBOTS, robot


def changed(problem: GaitProblem, **positions: tuple[float, float]) -> GaitProblem:
    limits = replace(problem.limits, positions={**problem.limits.positions, **positions})
    return replace(problem, limits=limits)


@pytest.mark.parametrize("name", ROBOTS)
def test_problems_by_default_are_possible(name: str, caplog: pytest.LogCaptureFixture) -> None:
    problem = gait_problem(robot(name), "trot", speed=0.3)
    caplog.clear()
    require_possible(problem)
    assert not caplog.records


def test_a_slope_is_possible() -> None:
    require_possible(gait_problem(catalogue.astro(), "trot", speed=0.2, ground=Plane(slope=0.17)))


IMPOSSIBLE: dict[str, tuple[Callable[[GaitProblem], GaitProblem], str]] = {
    "higher than legs are long": (lambda problem: changed(problem, z=(1.5, 2.0)), "the base must keep above 1.5 m"),
    "feet in the air": (
        lambda problem: replace(problem, posture=Posture(1.0, problem.posture.angles)),
        r"foot '..' is 0\.\d+ m above the ground; with these angles the height of the posture would be about 0\.297 m",
    ),
    "feet in the ground": (
        lambda problem: replace(problem, posture=Posture(0.02, problem.posture.angles)),
        r"foot '..' is -0\.\d+ m above the ground",
    ),
}


@pytest.mark.parametrize("name", IMPOSSIBLE)
def test_what_cannot_work_is_refused_before_the_solver(name: str, small_problem: GaitProblem) -> None:
    change, says = IMPOSSIBLE[name]
    with pytest.raises(InputError, match=says):
        synthesize(change(small_problem))


def test_a_posture_outside_its_bounds_is_told(small_problem: GaitProblem, caplog: pytest.LogCaptureFixture) -> None:
    """It was moved in silence."""
    require_possible(changed(small_problem, fl_knee=(1.5, 2.0)))
    assert "the posture has fl_knee at 1.16, outside 1.5 to 2; it is moved inside" in caplog.text
