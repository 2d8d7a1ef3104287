"""Gait problems by default: the builders' own for robots of the catalogue, by size and weight for any other."""

from __future__ import annotations

from dataclasses import replace
from math import inf, isfinite
from pathlib import Path

import numpy as np
import pytest

from amble.control import WeightedMinimumNorm
from amble.errors import InputError, UnknownNameError
from amble.gait.limits import highest_landing
from amble.hybrid import FLAT, POINT
from amble.hybrid.gaits import GAITS, amble, trot
from amble.robot import Robot, catalogue, load_robot, symmetrized
from amble.robot.kinematics import foot_position
from amble.robot.proposal import bent_ranges
from amble.synthesis import default_limits, gait_problem, standing_posture, synthesize
from amble.workflow.specified import pose
from benchmarks.fleet_style import walking_style
from tests.quadruped import FEET, urdf_of_four_joints
from tests.robots import robot

REAL = ("go2", "solo12", "anymal_b")


def test_a_robot_of_the_catalogue_has_its_builders_bounds() -> None:
    problem = gait_problem(catalogue.astro(), "amble", speed=0.2)
    bounds = catalogue.bounds("astro")
    assert dict(problem.limits.durations) == {"D1": bounds.duration, "D2": bounds.duration}
    assert problem.limits.positions == bounds.positions
    assert problem.posture == catalogue.posture("astro")
    shipped = pose(None).problem
    assert problem.pattern == shipped.pattern
    assert problem.outputs == shipped.outputs


def test_what_is_given_is_taken() -> None:
    astro = catalogue.astro()
    pattern = trot(astro)
    limits = replace(default_limits(pattern), clearance=0.03)
    law = WeightedMinimumNorm({"fl_knee": 2.0})
    problem = gait_problem(astro, pattern, speed=0.1, law=law, limits=limits, intervals=4)
    assert (problem.pattern, problem.law, problem.limits, problem.intervals) == (pattern, law, limits, 4)


def test_what_does_not_exist_or_fit_is_refused() -> None:
    astro = catalogue.astro()
    with pytest.raises(UnknownNameError, match="unknown gait 'gallop'; known: amble, trot"):
        gait_problem(astro, "gallop", speed=0.2)
    with pytest.raises(InputError, match="is of robot 'astro_cad', not of this one"):
        gait_problem(astro, trot(catalogue.astro_cad()), speed=0.2)


@pytest.mark.parametrize("name", REAL)
def test_a_real_robot_stands_on_its_feet_within_its_limits(name: str) -> None:
    model = robot(name)
    posture = standing_posture(model)
    q = posture.coordinates(model)
    for joint in model.joints:
        assert joint.lower <= posture.angles[joint.name] <= joint.upper
    heights = [float(np.asarray(foot_position(model, foot, q)).ravel()[2]) for foot in model.foot_names]
    assert heights == pytest.approx([0.0] * 4, abs=0.03 * model.leg_length)
    assert 0.3 < posture.height / model.leg_length < 0.7


@pytest.mark.parametrize("name", REAL)
@pytest.mark.parametrize("gait", ["amble", "trot"])
def test_a_real_robot_has_a_problem(name: str, gait: str) -> None:
    """What its file gives is kept; what it does not give scales with the robot."""
    model = symmetrized(robot(name))
    problem = gait_problem(model, gait, speed=0.3)
    assert dict(problem.limits.torques) == {
        joint.name: joint.effort for joint in model.joints if isfinite(joint.effort)
    }
    assert problem.limits.normal_force < 0.05 * model.mass * model.gravity
    assert problem.limits.clearance < 0.1 * model.leg_length
    assert problem.limits.touchdown_velocity[2][1] == highest_landing(model) < 0.0


@pytest.mark.parametrize("upper", [0.0, 0.1, inf, -0.01])
@pytest.mark.parametrize("name", ["astro", "astro_cad"])
def test_limits_under_which_a_foot_may_graze_the_ground_are_refused(name: str, upper: float) -> None:
    model = catalogue.load(name)
    limits = default_limits(amble(model))
    forward, sideways, (lower, most) = limits.touchdown_velocity
    assert most <= highest_landing(model)
    grazing = replace(limits, touchdown_velocity=(forward, sideways, (lower, upper)))
    with pytest.raises(InputError, match=f"may be as high as {upper:g} m/s, .* at most -0.05"):
        gait_problem(model, "amble", speed=0.2, limits=grazing)


def scaled(model: Robot, factor: float) -> Robot:
    """The robot with all lengths times a factor; masses stay."""
    joints = tuple(replace(joint, translation=factor * joint.translation) for joint in model.joints)
    feet = tuple(replace(foot, offset=factor * foot.offset) for foot in model.feet)
    return replace(model, joints=joints, feet=feet)


def test_limits_scale_with_the_robot() -> None:
    """Four times the size: times double, velocities double, angular accelerations a quarter, angles the same."""
    small = robot("go2")
    large = scaled(small, 4.0)
    one, four = (default_limits(trot(replace(model, symmetry_tolerance=1.0))) for model in (small, large))
    assert np.asarray(four.durations["D1"]) == pytest.approx(2.0 * np.asarray(one.durations["D1"]))
    assert four.acceleration == pytest.approx(one.acceleration / 4.0)
    assert np.asarray(four.touchdown_velocity) == pytest.approx(2.0 * np.asarray(one.touchdown_velocity))
    assert four.clearance == pytest.approx(4.0 * one.clearance)
    assert np.asarray(four.positions["z"]) == pytest.approx(4.0 * np.asarray(one.positions["z"]), rel=1e-6)
    angles = [standing_posture(model).angles for model in (small, large)]
    assert list(angles[0].values()) == pytest.approx(list(angles[1].values()), abs=1e-6)


def test_stances_that_end_by_a_force_last_longer() -> None:
    """A walk's stances of three feet, not those of two, which end as a foot lands."""
    model = replace(robot("go2"), symmetry_tolerance=1.0)
    pattern, time = GAITS["walk"](model, FLAT, POINT), np.sqrt(model.leg_length / model.gravity)
    limits = default_limits(pattern)
    for switch in pattern.switches:
        shortest = 0.15 if len(switch.source.feet) == 3 else 0.05
        assert limits.durations[switch.source.name] == pytest.approx((shortest * time, 0.75 * time))


@pytest.mark.parametrize("name", ["go2", "solo12"])
def test_default_limits_keep_a_style(name: str) -> None:
    """The base nearly level, feet that rise and land softly, knees bent as at the posture."""
    model = replace(robot(name), symmetry_tolerance=1.0)
    limits = default_limits(trot(model))
    length, velocity = model.leg_length, np.sqrt(model.gravity * model.leg_length)
    assert limits.positions["roll"] == limits.positions["pitch"] == (-0.1, 0.1)
    assert limits.clearance >= 0.08 * length
    assert np.linalg.norm([max(map(abs, interval)) for interval in limits.touchdown_velocity]) < 0.5 * velocity
    bent = bent_ranges(model, standing_posture(model).angles, np.radians(15.0))
    assert len(bent) == 4
    for knee, interval in bent.items():
        assert limits.positions[knee] == interval
        assert model.joint(knee).lower <= interval[0] < interval[1] <= model.joint(knee).upper


@pytest.fixture(scope="module")
def long_legged(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """Four joints a leg."""
    path: Path = tmp_path_factory.mktemp("robot") / "padda.urdf"
    path.write_text(urdf_of_four_joints())
    return load_robot(path, FEET)


def test_legs_of_four_joints_stand_and_have_a_problem(long_legged: Robot) -> None:
    assert all(len(leg) == 4 for leg in long_legged.legs.values())
    problem = gait_problem(long_legged, "trot", speed=0.3)
    q = problem.posture.coordinates(long_legged)
    heights = [float(foot_position(long_legged, foot, q)[2]) for foot in long_legged.foot_names]
    assert heights == pytest.approx([0.0] * 4, abs=1e-6)
    # two point feet let the base turn about the line between them, and one joint only squeezes them
    assert [len(problem.outputs.of(stance.name).coordinates) for stance in problem.pattern.solved] == [15]


@pytest.mark.slow
def test_legs_of_four_joints_trot(long_legged: Robot, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")  # solving once is shorter than compiling
    gait = synthesize(gait_problem(long_legged, "trot", speed=0.3, intervals=4))
    assert gait.solver.violation < 1e-6
    assert walking_style(gait).missed == ()


def test_legs_without_two_pitch_joints_need_a_posture() -> None:
    model = robot("go2")
    stiff = replace(
        model,
        joints=tuple(
            replace(joint, axis=np.array([1.0, 0.0, 0.0])) if "calf" in joint.name else joint for joint in model.joints
        ),
    )
    with pytest.raises(InputError, match="no two pitch joints"):
        standing_posture(stiff)
