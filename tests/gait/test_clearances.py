"""Clearances and motors: what they refuse, their rows against frames multiplied out in numpy, files, the check."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any, cast

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.gait.clearances import Clearances, Motor, check_clearances, gaps_between_legs, hanging, heights
from amble.gait.files import from_dict, to_dict
from amble.hybrid import FLAT, Plane
from amble.robot import kinematics
from amble.synthesis import gait_problem, synthesize
from amble.synthesis.clearance_rows import clearance_rows
from amble.synthesis.specification import specification_of
from amble.synthesis.specified import problem_of
from amble.verification.check import check
from amble.verification.clearance_rows import Frames, clearance_residuals
from amble.verification.domain_rows import SampledDomain, sampled
from tests.robots import PLANAR, random_states, robot

ALL = Clearances(knees=0.05, corners=0.1, box=(0.4, 0.2, 0.1), legs=0.03)


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"knees": 0.0}, "'knees' is 0.0 m"),
        ({"legs": -0.1}, "'legs' is -0.1 m"),
        ({"corners": float("nan"), "box": (1.0, 1.0, 1.0)}, "'corners' is nan m"),
        ({"corners": 0.1}, "need both 'corners'"),
        ({"box": (0.4, 0.2, 0.1)}, "need both 'corners'"),
        ({"corners": 0.1, "box": (0.4, float("inf"), 0.1)}, "'box along y' is inf m"),
    ],
)
def test_what_is_no_length_is_refused(given: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        Clearances(**given)


@pytest.mark.parametrize("given", [(0.0, 1.0), (1.0, -1.0), (float("inf"), 1.0)])
def test_what_is_no_motor_is_refused(given: tuple[float, float]) -> None:
    with pytest.raises(InputError, match="finite and positive"):
        Motor(stall_torque=given[0], no_load_speed=given[1])


def test_a_motor_gives_its_stall_torque_at_rest_and_none_at_its_no_load_speed() -> None:
    motor = Motor(stall_torque=20.0, no_load_speed=30.0)
    for torque, speed, used in ((20.0, 0.0, 1.0), (0.0, 30.0, 1.0), (-20.0, 0.0, -1.0), (20.0, -30.0, 0.0)):
        assert float(motor.used(torque, speed)) == pytest.approx(used)


def test_legs_that_cannot_be_apart_are_refused() -> None:
    planar = robot(PLANAR)
    with pytest.raises(InputError, match="moves in a plane, where legs pass each other"):
        check_clearances(planar, Clearances(legs=0.1))
    check_clearances(planar, Clearances(knees=0.1))
    with pytest.raises(InputError, match="has none: give twins"):
        check_clearances(replace(robot("astro"), twins=()), Clearances(legs=0.1))


@pytest.mark.parametrize("name", ["astro", "go2", PLANAR])
@pytest.mark.parametrize("ground", [FLAT, Plane(slope=0.2)], ids=["level", "slope"])
def test_rows_are_the_distances_of_frames_multiplied_out(name: str, ground: Plane) -> None:
    walker = robot(name)
    q, _ = random_states(walker, 5, seed=3)
    asked = ALL if walker.base.in_space else replace(ALL, legs=None)
    symbols = ca.SX.sym("q", walker.size)
    written = heights(walker, ground, asked, symbols) | gaps_between_legs(walker, asked, symbols)
    found = ca.Function("rows", [symbols], [ca.vertcat(*(row for row, _ in written.values()))])
    frames = Frames.of(walker, q)
    domain = cast(SampledDomain, SimpleNamespace(contacts=SimpleNamespace(ground=ground)))
    expected = {f"height of joint {joint}": frames.height(domain, frames.origin(joint)) for joint in frames.knees}
    expected |= {
        f"height of base corner {k}": frames.height(domain, c) for k, c in frames.corners(ALL.box or ()).items()
    }
    expected |= frames.apart() if walker.base.in_space else {}
    assert list(written) == list(expected)
    for number, state in enumerate(q):
        values = np.asarray(found(state)).ravel()
        np.testing.assert_allclose(values, [row[number] for row in expected.values()], atol=1e-12)


def test_knees_are_where_the_links_are() -> None:
    """And no hip is among them."""
    astro = robot("astro")
    knees = hanging(astro, astro.foot_names)
    assert set(knees) < set(astro.joint_names)
    assert not any("roll" in joint for joint in knees)
    q, _ = random_states(astro, 1, seed=4)
    frames = Frames.of(astro, q)
    for joint in knees:
        world = np.asarray(kinematics.link_pose(astro, astro.joints[astro.joint_index(joint)].child, q[0])[1]).ravel()
        base = np.asarray(kinematics.base_rotation(q[0])) @ frames.origin(joint)[0] + q[0, :3]
        np.testing.assert_allclose(base, world, atol=1e-12)


def test_a_problem_has_rows_only_where_it_is_asked_for_them() -> None:
    problem = gait_problem(robot("astro"), "trot", speed=0.2, intervals=2)
    contacts = problem.pattern.contacts(problem.pattern.solved[0])
    symbols = [ca.SX.sym(letter, size) for letter, size in (("q", 18), ("v", 18), ("u", 12))]
    assert clearance_rows(problem, contacts, *symbols).rows == []
    motor = Motor(stall_torque=20.0, no_load_speed=30.0)
    joint = problem.pattern.robot.joint_names[4]
    asking = replace(problem, limits=replace(problem.limits, clearances=ALL, motors={joint: motor}))
    group = clearance_rows(asking, contacts, *symbols)
    assert len(group.rows) == len(group.labels) == len(group.lower) == len(group.upper)
    assert [label.name for label in group.labels][-1] == f"torque over speed {joint}"
    assert all(
        low >= least for low, least in zip(group.lower, [0.05] * 8 + [0.1] * 4 + [0.03] * 6 + [-1.0], strict=True)
    )
    at = ca.Function("row", symbols, [group.rows[-1]])
    assert float(at(0.0, np.eye(18)[10] * 15.0, np.eye(12)[4] * 10.0)) == pytest.approx(1.0)


def test_problems_refuse_joints_that_there_are_not() -> None:
    problem = gait_problem(robot("astro"), "trot", speed=0.2, intervals=2)
    with pytest.raises(UnknownNameError, match="motor"):
        replace(problem, limits=replace(problem.limits, motors={"tail": Motor(stall_torque=1.0, no_load_speed=1.0)}))


def test_a_specification_gives_them() -> None:
    tree = {
        "robot": {"name": "astro"},
        "gait": {"name": "trot", "speed": 0.2},
        "limits": {
            "clearances": {"knees": "5 cm", "corners": 0.1, "box": [0.4, "20 cm", 0.1], "legs": "3 cm"},
            "motor": {"stall_torque": "40 N m", "no_load_speed": 25.0},
        },
    }
    limits = problem_of(specification_of(tree, "spec.toml")).limits
    assert limits.clearances == ALL
    assert limits.motors == dict.fromkeys(robot("astro").joint_names, Motor(stall_torque=40.0, no_load_speed=25.0))


def test_a_gait_file_holds_them_and_one_without_is_as_before(walking_gait: Gait) -> None:
    joint = walking_gait.robot.joint_names[0]
    motors = {joint: Motor(stall_torque=40.0, no_load_speed=25.0)}
    asking = replace(walking_gait, limits=replace(walking_gait.limits, clearances=ALL, motors=motors))
    assert from_dict(to_dict(asking)).limits == asking.limits
    assert not {"clearances", "motors"} & set(to_dict(walking_gait)["limits"])


def test_the_check_sees_what_is_too_low_and_what_the_motor_cannot_give(walking_gait: Gait) -> None:
    torque = max(float(np.abs(part.torques).max()) for part in walking_gait.domains)
    speed = max(float(np.abs(part.velocities[:, 6:]).max()) for part in walking_gait.domains)
    kept, missed = (
        replace(
            walking_gait.limits,
            clearances=clearances,
            motors=dict.fromkeys(walking_gait.robot.joint_names, Motor(stall_torque=stall, no_load_speed=20.0 * speed)),
        )
        for clearances, stall in ((ALL, 2.0 * torque), (replace(ALL, knees=1.0, corners=1.0, legs=1.0), 0.5 * torque))
    )
    for limits, holds in ((kept, True), (missed, False)):
        domain = sampled(replace(walking_gait, limits=limits), 0, 1)
        rows = clearance_residuals(domain, 1e-3)
        by_kind = {kind: [row.passed for row in rows if row.kind == kind] for kind in ("clearances", "motor")}
        assert all(by_kind["clearances"]) == holds
        assert all(by_kind["motor"]) == holds
        assert len(by_kind["clearances"]) == 8 + 4 + 6


@pytest.mark.slow
def test_a_gait_keeps_what_is_asked_of_it_between_its_nodes_too() -> None:
    """Each bound a little tighter than the gait without it comes to."""
    problem = gait_problem(robot("astro"), "trot", speed=0.3, intervals=10)
    free = synthesize(problem)
    frames = [Frames.of(free.robot, part.positions) for part in free.domains]
    domain = cast(SampledDomain, SimpleNamespace(contacts=free.pattern.contacts(free.pattern.solved[0])))
    knees = min(float(f.height(domain, f.origin(joint)).min()) for f in frames for joint in f.knees)
    apart = min(float(gap.min()) for f in frames for gap in f.apart().values())
    joint = free.robot.joint_names[1]
    used = 0.95 * max(
        float(np.abs(part.torques[:, 1] / 40.0 + part.velocities[:, 7] / 10.0).max()) for part in free.domains
    )
    asked = replace(
        problem.limits,
        clearances=Clearances(knees=knees + 0.01, legs=apart + 0.005),
        motors={joint: Motor(stall_torque=40.0 * used, no_load_speed=10.0 * used)},
    )
    kept = synthesize(replace(problem, limits=asked, node_margins=True))
    assert kept.solver.objective > free.solver.objective
    assert [str(row) for row in check(kept).failed] == []
    failed = {row.kind for row in check(replace(free, limits=asked)).failed}
    assert failed == {"clearances", "motor"}
