"""Kinematics of point feet against Pinocchio at 1,000 seeded random states, and against derivatives."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.errors import UnknownNameError
from amble.robot import Robot, kinematics
from amble.robot.kinematics import aligned_joint_frames
from amble.robot.rotation import constant
from tests.oracle import oracle
from tests.robot.sampling import relative_error, sampled, theirs
from tests.robots import EVERY_BASE, random_states, robot

STATES = 1000
TOLERANCE = 1e-10  # the promise; roundings of short chains, measured about 1e-15


@pytest.mark.parametrize("name", EVERY_BASE)
def test_positions_equal_pinocchio(name: str) -> None:
    model = robot(name)
    q, _ = random_states(model, STATES)
    ours = sampled(model, lambda q: ca.vertcat(*(kinematics.foot_position(model, f, q) for f in model.foot_names)), q)
    expected = theirs(lambda q: oracle(name).positions(q).ravel(), q)
    assert relative_error(ours, expected) < TOLERANCE


@pytest.mark.parametrize("name", EVERY_BASE)
def test_jacobians_equal_pinocchio(name: str) -> None:
    model = robot(name)
    q, _ = random_states(model, STATES, seed=1)
    ours = sampled(model, lambda q: ca.vertcat(*(kinematics.foot_jacobian(model, f, q) for f in model.foot_names)), q)
    assert relative_error(ours, theirs(oracle(name).jacobian, q)) < TOLERANCE


@pytest.mark.parametrize("name", EVERY_BASE)
def test_jacobian_biases_equal_pinocchio(name: str) -> None:
    model = robot(name)
    q, v = random_states(model, STATES, seed=2)
    ours = sampled(
        model, lambda q, v: ca.vertcat(*(kinematics.foot_bias(model, f, q, v) for f in model.foot_names)), q, v
    )
    assert relative_error(ours, theirs(oracle(name).jacobian_bias, q, v)) < TOLERANCE


@pytest.mark.parametrize("name", EVERY_BASE)
def test_jacobian_and_bias_are_derivatives_of_the_position(name: str) -> None:
    model = robot(name)
    q, v = random_states(model, 20, seed=3)
    for foot in model.foot_names:
        jacobian = sampled(model, lambda q, foot=foot: kinematics.foot_jacobian(model, foot, q), q)
        derived = sampled(model, lambda q, foot=foot: ca.jacobian(kinematics.foot_position(model, foot, q), q), q)
        assert relative_error(jacobian, derived) < 1e-13  # a few dozen roundings

        def second(q: ca.SX, v: ca.SX, foot: str = foot) -> ca.SX:
            return ca.jtimes(ca.jtimes(kinematics.foot_position(model, foot, q), q, v), q, v)

        bias = sampled(model, lambda q, v, foot=foot: kinematics.foot_bias(model, foot, q, v), q, v)
        assert relative_error(bias, sampled(model, second, q, v)) < 1e-12  # second derivatives: longer chains


def test_base_rotation_is_roll_then_pitch_then_yaw_in_turning_axes() -> None:
    """R = Rx Ry Rz: a unit x turned by yaw stays in the base's own plane, then pitches, then rolls."""
    q = np.zeros(18)
    q[5] = np.pi / 2
    np.testing.assert_allclose(np.asarray(kinematics.base_rotation(q)) @ [1, 0, 0], [0, 1, 0], atol=1e-15)
    q[3] = np.pi / 2  # roll turns the already yawed x axis upwards
    np.testing.assert_allclose(np.asarray(kinematics.base_rotation(q)) @ [1, 0, 0], [0, 0, 1], atol=1e-15)


def test_angle_axes_map_rates_to_body_angular_velocity() -> None:
    q, v = random_states(robot("astro"), 20, seed=4)
    rotation = sampled(robot("astro"), lambda q, v: ca.jtimes(kinematics.base_rotation(q), q, v), q, v)
    for pose, rate, slope in zip(q, v, rotation, strict=True):
        spin = np.asarray(kinematics.base_rotation(pose)).T @ slope.reshape(3, 3, order="F")
        body = np.asarray(kinematics.angle_axes(pose)) @ rate[3:6]
        np.testing.assert_allclose([spin[2, 1], spin[0, 2], spin[1, 0]], body, atol=1e-14 * np.abs(rate[3:6]).sum())


def test_jacobian_columns_of_other_legs_are_structurally_zero() -> None:
    model = robot("astro")
    pattern = np.asarray(ca.DM(kinematics.foot_jacobian(model, "fl", ca.SX.sym("q", model.size)).sparsity(), 1.0))
    nonzero = {model.coordinate_names[i] for i in np.flatnonzero(pattern.any(axis=0))}
    assert nonzero == {"x", "y", "z", "roll", "pitch", "yaw", *model.legs["fl"]}


def test_unknown_foot_names_those_that_exist() -> None:
    model = robot("astro")
    for function in (kinematics.foot_position, kinematics.foot_jacobian):
        with pytest.raises(UnknownNameError, match="unknown foot 'tail'; known: fl, rl, fr, rr"):
            function(model, "tail", np.zeros(model.size))
    with pytest.raises(UnknownNameError, match="unknown foot 'tail'"):
        kinematics.foot_bias(model, "tail", np.zeros(model.size), np.zeros(model.size))


def feet_from_links(model: Robot, q: ca.SX) -> ca.SX:
    positions = []
    for foot in model.feet:
        rotation, origin = kinematics.link_pose(model, foot.link, q)
        positions.append(origin + rotation @ constant(foot.offset))
    return ca.vertcat(*positions)


@pytest.mark.parametrize("name", EVERY_BASE)
def test_arms_are_normal_to_axes_and_feet_stay(name: str) -> None:
    model = robot(name)
    moved = aligned_joint_frames(model)
    for joint in moved.joints:
        assert abs((joint.rotation @ joint.axis) @ joint.translation) < 1e-15
    q, _ = random_states(model, 20, seed=12)
    before, after = (sampled(model, lambda q, of=of: feet_from_links(of, q), q) for of in (model, moved))
    assert relative_error(after, before) < 1e-14  # a few dozen roundings
    assert moved.mass == model.mass
    assert moved.joint_names == model.joint_names
