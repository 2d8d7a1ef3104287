"""Which coordinates a domain controls: defaults, choices, and the choices that are refused."""

from __future__ import annotations

import itertools
from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from amble.control.motion_equations import MotionEquations
from amble.control.outputs import (
    Outputs,
    actuated_freedoms,
    controllable,
    joint_outputs,
    least_share,
    left_out,
    left_out_along,
    rear_hip_pitch,
    selection_matrix,
)
from amble.errors import InputError, UnknownNameError
from amble.hybrid import Contacts, GaitPattern, constrained_dynamics, gait_pattern
from amble.hybrid.gaits import amble, trot
from amble.robot import Robot
from amble.robot.proposal import nominal_posture
from amble.types import Matrix
from tests.control.allocation.stances import random_postures
from tests.robots import ROBOTS, robot

HIP_PITCH = {"astro": "rr_hip_pitch", "astro_cad": "rr_hip_pitch", "solo12": "HR_HFE", "go2": "RR_thigh_joint",
             "anymal_b": "RH_HFE"}  # fmt: skip


def astro() -> Robot:
    return robot("astro")


def test_the_amble_leaves_the_rear_stance_hip_pitch_out() -> None:
    outputs = joint_outputs(amble(astro()))
    assert outputs.order == 4
    for name, free in (("D1", "rl_hip_pitch"), ("D2", "rr_hip_pitch")):
        expected = tuple(joint for joint in astro().joint_names if joint != free)
        assert outputs.of(name).coordinates == expected


@pytest.mark.parametrize("name", ROBOTS)
def test_the_rear_hip_pitch_is_found_by_geometry(name: str) -> None:
    pattern = trot(robot(name))
    stance = pattern.stance("D1")
    assert stance.feet == tuple(foot for foot in robot(name).foot_names if foot in ("fl", "rr"))
    assert rear_hip_pitch(pattern, stance) == HIP_PITCH[name]
    assert left_out(pattern, stance) == (HIP_PITCH[name],)


@pytest.mark.parametrize("feet", [("fl", "fr"), ("fl", "rl", "rr")])
def test_joints_left_out_along_a_motion_are_as_good_as_any(feet: tuple[str, ...]) -> None:
    """From the worst choice, exchanged one by one, against all choices; least_share by its definition."""
    pattern = gait_pattern(astro(), (feet, astro().foot_names))
    stance, names = pattern.stances[0], astro().joint_names
    poses = random_postures("astro", 3, 0)[0]
    shares = {}
    for free in itertools.combinations(names, pattern.contacts(stance).internal_force_count):
        kept = tuple(joint for joint in names if joint not in free)
        shares[free] = least_share(pattern, stance, kept, poses)
    worst, best = min(shares, key=shares.__getitem__), max(shares.values())
    found = left_out_along(pattern, stance, tuple(joint for joint in names if joint not in worst), poses)
    assert shares[found] > 0.8 * best > 10.0 * shares[worst]
    q = ca.SX.sym("q", astro().size)
    basis = ca.Function("basis", [q], [ca.densify(pattern.contacts(stance).torque_null_space(q)[0])])
    rows = [names.index(joint) for joint in found]
    sizes = [np.linalg.svd(np.linalg.qr(np.asarray(basis(pose)))[0][rows], compute_uv=False)[-1] for pose in poses]
    assert shares[found] == pytest.approx(min(sizes))


STANCES = [("fl", "fr"), ("rl", "rr"), ("fl", "rl"), ("fl", "rr"), ("fl", "fr", "rr"), ("fl", "fr", "rl", "rr")]


def smallest_pivot(pattern: GaitPattern, outputs: Outputs, poses: Matrix) -> float:
    """The pivot that every closed loop watches, which stops a simulation below 1e-6."""
    q = ca.SX.sym("q", pattern.robot.size)
    kernel = np.eye(len(controllable(pattern.robot)))
    chosen = selection_matrix(pattern.robot, outputs.of("D1"))
    kernel = kernel[:, ~chosen.any(axis=0)]
    equations = MotionEquations.of(pattern.contacts(pattern.stances[0]), q, ca.SX(ca.DM(kernel)))
    return float(ca.mmin(ca.Function("pivots", [q], [equations.pivots])(poses.T)))


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("feet", STANCES, ids="-".join)
def test_default_outputs_are_regular_on_any_stance(name: str, feet: tuple[str, ...]) -> None:
    """On two lateral feet the hip pitch, the only default before, had a pivot of 3e-4 at best; three had no default."""
    pattern = gait_pattern(robot(name), [feet, ("fl",)])
    poses = np.tile(nominal_posture(robot(name)).coordinates(robot(name)), (11, 1))
    poses[1:, 3:] += np.random.default_rng(5).uniform(-0.1, 0.1, poses[1:, 3:].shape)
    assert smallest_pivot(pattern, joint_outputs(pattern), poses) > 0.01


def test_the_choice_is_the_best_of_all_for_two_feet() -> None:
    model = robot("go2")
    pattern = gait_pattern(model, [("fl", "fr"), ("fl",)])
    posture = nominal_posture(model).coordinates(model)[None]
    each = {
        joint: smallest_pivot(pattern, joint_outputs(pattern, free={"D1": [joint]}), posture)
        for joint in model.legs["fl"] + model.legs["fr"]
    }
    (chosen,) = left_out(pattern, pattern.stances[0])
    assert each[chosen] == pytest.approx(max(each.values()), rel=1e-3)
    assert each["FL_thigh_joint"] < 1e-3 < 0.1 < each[chosen]


@pytest.mark.parametrize("count", [0, 1, 2, 3, 4])
def test_actuated_freedoms_is_the_rank_of_the_input_map(count: int) -> None:
    model, feet = astro(), astro().foot_names[:count]
    q, v = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size)
    motion = constrained_dynamics(Contacts(model, feet), q, v)
    function = ca.Function("G", [q, v], [motion.input_map])
    for pose, rate in zip(*random_postures("astro", 5, seed=31), strict=True):
        inputs = np.asarray(function(pose, rate).full())
        values = np.linalg.svd(inputs, compute_uv=False)
        assert np.sum(values > 1e-9 * values[0]) == actuated_freedoms(Contacts(model, feet))


def test_one_foot_and_no_foot_leave_nothing_out() -> None:
    pattern = gait_pattern(astro(), [("fl",), ()])
    outputs = joint_outputs(pattern)
    assert all(len(outputs.of(name).coordinates) == 12 for name in ("D1", "D2"))


def test_an_empty_choice_is_a_choice() -> None:
    """It meant the default, so that a stance on two feet that should leave nothing out silently left the hip out."""
    with pytest.raises(InputError, match=r"11 actuated degrees of freedom, but 12 outputs \(left out: none\)"):
        joint_outputs(amble(astro()), free={"D1": []})
    single = gait_pattern(astro(), [("fl",), ()])
    assert joint_outputs(single, free={"D1": []}) == joint_outputs(single)


def test_the_user_may_choose() -> None:
    outputs = joint_outputs(amble(astro()), order=5, free={"D1": ["fr_knee"]})
    assert outputs.order == 5
    assert "fr_knee" not in outputs.of("D1").coordinates
    assert "rl_hip_pitch" in outputs.of("D1").coordinates
    assert "rr_hip_pitch" not in outputs.of("D2").coordinates  # D2 keeps its default


def test_selection_matrix_picks_the_controlled_coordinates() -> None:
    outputs = joint_outputs(amble(astro()))
    names = controllable(astro())
    assert names[:4] == ("roll", "pitch", "yaw", astro().joint_names[0])
    matrix = selection_matrix(astro(), outputs.of("D1"))
    picked = [names[int(place)] for place in matrix @ np.arange(len(names))]
    assert tuple(picked) == outputs.of("D1").coordinates
    np.testing.assert_array_equal(matrix @ matrix.T, np.eye(11))


REFUSED: list[tuple[Callable[[], Outputs], type[InputError], str]] = [
    (lambda: joint_outputs(amble(astro()), order=2), InputError, "at least 3"),
    (lambda: joint_outputs(amble(astro()), order=15), InputError, "is 15; the closed loop takes up to 14"),
    (lambda: joint_outputs(amble(astro()), free={"D3": []}), UnknownNameError, "unknown domain 'D3'; known: D1, D2"),
    (lambda: joint_outputs(amble(astro()), free={"D1": ["knee"]}), UnknownNameError, "unknown joint 'knee'; known: "),
    (
        lambda: joint_outputs(amble(astro()), free={"D1": ["fr_knee", "rl_knee"]}),
        InputError,
        "has 11 actuated degrees of freedom, but 10 outputs .left out: fr_knee, rl_knee",
    ),
]


@pytest.mark.parametrize(("build", "error", "says"), REFUSED, ids=[says for *_, says in REFUSED])
def test_refused(build: Callable[[], Outputs], error: type[InputError], says: str) -> None:
    with pytest.raises(error, match=says):
        build()


def test_an_unknown_domain_says_what_is_known() -> None:
    with pytest.raises(UnknownNameError, match="unknown domain 'D9'; known: D1, D2"):
        joint_outputs(amble(astro())).of("D9")
