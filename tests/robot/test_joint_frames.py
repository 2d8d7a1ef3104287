"""Sliding joint frames along their axes: arms lose their part along the axis, feet stay where they are."""

from __future__ import annotations

import casadi as ca
import pytest

from amble.robot import Robot, kinematics
from amble.robot.joint_frames import aligned_joint_frames
from amble.robot.rotation import constant
from tests.robot.sampling import relative_error, sampled
from tests.robots import ROBOTS, random_states, robot


def feet_from_links(model: Robot, q: ca.SX) -> ca.SX:
    positions = []
    for foot in model.feet:
        rotation, origin = kinematics.link_pose(model, foot.link, q)
        positions.append(origin + rotation @ constant(foot.offset))
    return ca.vertcat(*positions)


@pytest.mark.parametrize("name", ROBOTS)
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
