"""What is proposed for a robot ends in a second or is refused by name, whatever the robot looks like."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.robot import Robot
from amble.robot.catalogue import Posture
from amble.robot.kinematics import foot_position, link_pose, zero_poses
from amble.robot.parts import Foot, Joint, Link
from amble.robot.plausibility import doubts, reach
from amble.robot.proposal import bent_ranges, standing_posture
from amble.robot.validation import MOST_JOINTS
from amble.types import frozen
from tests.robots import ROBOTS, robot


def chain(count: int, step: float) -> Robot:
    """A base and one leg of so many pitch joints, each so far below the one before."""
    links = tuple(Link(f"l{n}", 1.0, frozen(np.zeros(3)), frozen(0.01 * np.eye(3))) for n in range(count + 1))
    at = frozen([0.0, 0.0, -step])
    joints = tuple(
        Joint(
            name=f"j{n}",
            parent=n,
            child=n + 1,
            rotation=frozen(np.eye(3)),
            translation=at,
            axis=frozen([0.0, 1.0, 0.0]),
            lower=-2.0,
            upper=2.0,
            effort=1.0,
            velocity=1.0,
        )
        for n in range(count)
    )
    feet = (Foot("a", f"l{count}", count, at),)
    return Robot(name="chain", source="chain.urdf", links=links, joints=joints, feet=feet, gravity=9.81)


@pytest.mark.parametrize("name", ROBOTS)
def test_poses_in_numbers_are_those_in_symbols(name: str) -> None:
    model = robot(name)
    for number, (rotation, origin) in enumerate(zero_poses(model)):
        expected = link_pose(model, number, np.zeros(model.size))
        np.testing.assert_allclose(rotation, np.asarray(expected[0]), atol=1e-14)
        np.testing.assert_allclose(origin, np.asarray(expected[1]).ravel(), atol=1e-14)


def test_a_chain_of_as_many_joints_as_a_robot_may_have_is_doubted_in_linear_time() -> None:
    begun = time.process_time()
    model = chain(MOST_JOINTS, 0.1)
    assert reach(model) == pytest.approx((MOST_JOINTS + 1) * 0.1 * 2.0)
    doubts(model)
    assert time.process_time() - begun < 5.0


@pytest.mark.parametrize("count", [13, 50, MOST_JOINTS])
def test_no_posture_is_searched_for_a_leg_of_very_many_joints(count: int) -> None:
    begun = time.process_time()
    with pytest.raises(InputError, match=f"has {count} pitch joints, more than 12"):
        standing_posture(chain(count, 0.1))
    assert time.process_time() - begun < 5.0


def test_a_leg_without_length_is_named() -> None:
    with pytest.raises(InputError, match="leg 'a' and its foot are one point"):
        standing_posture(chain(3, 0.0))
    stretched = chain(3, 0.1)
    assert standing_posture(stretched).height > 0.0
    flat = replace(stretched.feet[0], offset=frozen(np.zeros(3)))
    assert standing_posture(replace(stretched, feet=(flat,))).height > 0.0


@pytest.mark.parametrize("name", ["go2", "solo12", "anymal_b"])
def test_a_leg_at_the_edge_of_its_bent_range_is_that_far_off_straight(name: str) -> None:
    """Thigh and shank as vectors of the kinematics, at the posture with one knee moved to the edge."""
    model, least = robot(name), 0.4
    posture = standing_posture(model)
    ranges = bent_ranges(model, posture.angles, least)
    knees = {leg[-1]: foot for foot, leg in model.legs.items()}
    assert set(ranges) == set(knees)
    for knee, (lower, upper) in ranges.items():
        record, leg = model.joint(knee), model.legs[knees[knee]]
        assert lower < posture.angles[knee] < upper
        edge = {lower, upper} - {record.lower, record.upper}
        for value in edge or {record.lower, record.upper}:
            q = Posture(0.3, {**posture.angles, knee: value}).coordinates(model)
            hip, at = (np.asarray(link_pose(model, model.joint(j).child, q)[1]).ravel() for j in leg[-2:])
            foot = np.asarray(foot_position(model, knees[knee], q)).ravel()
            upper_leg, lower_leg = (at - hip)[[0, 2]], (foot - at)[[0, 2]]
            cosine = upper_leg @ lower_leg / np.linalg.norm(upper_leg) / np.linalg.norm(lower_leg)
            # where a joint limit is nearer than the edge, it stays
            assert np.arccos(cosine) == pytest.approx(least, abs=1e-9) if edge else np.arccos(cosine) >= least
