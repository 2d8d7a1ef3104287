"""Commands beside straight ahead: lateral, turning, in place; closed modulo way and turn, by independent means."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.analysis import samples_of_gait
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait, save_gait, to_dict
from amble.hybrid import SIMULTANEOUS, Plane
from amble.hybrid.gaits import trot
from amble.robot import kinematics
from amble.robot.turn import turned
from amble.synthesis import gait_problem, synthesize
from amble.synthesis.layout import build_layout, variable_bounds
from amble.verification.check import check
from tests.robots import robot

COMMANDS = {"lateral": (0.2, 0.1, 0.0), "turning": (0.2, 0.0, 0.6), "sideways turn": (0.0, 0.15, -0.5)}


@pytest.fixture(
    scope="module",
    # the last has both, so the others are for `make slow`
    params=[*(pytest.param(name, marks=pytest.mark.slow) for name in ("lateral", "turning")), "sideways turn"],
)
def gait(request: pytest.FixtureRequest) -> Gait:
    speed, lateral, rate = COMMANDS[request.param]
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("AMBLE_COMPILER", "none")  # solving once is shorter than compiling
        problem = gait_problem(robot("astro"), "trot", speed=speed, lateral_speed=lateral, yaw_rate=rate, intervals=6)
        assert not problem.pattern.mirrored
        # commands are no matter of the landing rule, and this one is the quicker
        problem = replace(problem, pattern=replace(problem.pattern, landing_rule=SIMULTANEOUS))
        return synthesize(problem)


def test_it_closes_modulo_its_way_and_its_turn(gait: Gait) -> None:
    """Feet of the next first stance: where they end is where they began, turned and moved; solved to 1e-8."""
    first, last = gait.domains[0], gait.domains[-1]
    x, y, angle = gait.command.way(gait.period)
    about = np.array([[np.cos(angle), -np.sin(angle), 0.0], [np.sin(angle), np.cos(angle), 0.0], [0.0, 0.0, 1.0]])
    base = first.positions[0, :3]
    for foot in gait.robot.foot_names:
        begin, end = (
            np.asarray(kinematics.foot_position(gait.robot, foot, q)).ravel()
            for q in (first.positions[0], last.positions[-1])
        )
        np.testing.assert_allclose(end, base + [x, y, 0.0] + about @ (begin - base), atol=1e-8)
    np.testing.assert_allclose(last.positions[-1, 6:], first.positions[0, 6:], atol=1e-8)


def test_its_check_sees_another_command(gait: Gait) -> None:
    # on six intervals a motion between the nodes is off by 1e-4; what the switches say holds at the nodes
    kinds = ("periodicity", "continuity", "impact")
    rows = [row for row in check(gait, grid=1, tolerance=1e-6).rows if row.kind in kinds]
    assert rows
    assert all(row.passed for row in rows)
    other = replace(gait, lateral_speed=gait.lateral_speed + 0.01)
    assert {row.kind for row in check(other, grid=1, tolerance=1e-6).failed} >= {"periodicity"}


def test_several_cycles_hang_together(gait: Gait) -> None:
    samples = samples_of_gait(gait, cycles=3)
    joins = np.flatnonzero(np.diff(samples.segments))
    np.testing.assert_allclose(samples.positions[joins], samples.positions[joins + 1], atol=1e-8)
    x, y, _ = gait.command.way(3.0 * gait.period)
    way = samples.positions[-1, :2] - samples.positions[0, :2]
    np.testing.assert_allclose(way, [x, y], atol=1e-6)
    assert samples.distance == pytest.approx(3.0 * np.hypot(*gait.command.way(gait.period)[:2]), rel=1e-6)


def test_a_file_holds_the_command(gait: Gait, tmp_path: Path) -> None:
    read = load_gait(save_gait(gait, tmp_path / "gait.json"))
    assert (read.lateral_speed, read.yaw_rate) == (gait.lateral_speed, gait.yaw_rate)
    straight = to_dict(replace(gait, lateral_speed=0.0, yaw_rate=0.0))
    assert not {"lateral_speed", "yaw_rate"} & set(straight)


def test_what_no_pattern_or_ground_can_do() -> None:
    astro = robot("astro")
    with pytest.raises(InputError, match="goes straight ahead"):
        gait_problem(astro, trot(astro), speed=0.2, yaw_rate=0.1)
    with pytest.raises(InputError, match="needs level ground"):
        gait_problem(astro, "trot", speed=0.2, yaw_rate=0.1, ground=Plane(slope=0.1))


def test_in_place_the_heading_is_pinned() -> None:
    astro = robot("astro")
    for speed, pinned in ((0.0, True), (0.2, False)):
        problem = gait_problem(astro, replace(trot(astro), mirrored=False), speed=speed, intervals=2)
        layout = build_layout(problem)
        lower, upper = variable_bounds(problem, layout)
        yaw = layout.domains[0].q[0, astro.coordinate_index("yaw")]
        assert (lower[yaw] == upper[yaw] == 0.0) == pinned


def test_turned_states_are_the_same_robot(gait: Gait) -> None:
    q, v = gait.domains[0].positions, gait.domains[0].velocities
    back = turned(*turned(q, v, 0.4), -0.4)
    np.testing.assert_allclose(back[0], q, atol=1e-12)
    np.testing.assert_allclose(back[1], v, atol=1e-10)
