"""The catalogue: numbers of the published model, the posture stands, the bounds sprawl outwards."""

from __future__ import annotations

import numpy as np
import pytest

from amble.errors import UnknownNameError
from amble.robot import catalogue, kinematics
from tests.robots import CATALOGUE


def test_names_load() -> None:
    assert catalogue.names() == CATALOGUE
    for name in catalogue.names():
        assert catalogue.load(name).name == name
    assert catalogue.astro() == catalogue.load("astro")
    assert catalogue.astro_cad() == catalogue.load("astro_cad")
    assert catalogue.astro() != catalogue.astro_cad()


def test_unknown_robot_names_those_that_exist() -> None:
    with pytest.raises(UnknownNameError, match="unknown robot 'spot'; known: astro, astro_cad"):
        catalogue.load("spot")


@pytest.mark.parametrize("name", CATALOGUE)
def test_limits(name: str) -> None:
    model = catalogue.load(name)
    assert {joint.effort for joint in model.joints} == {48.0}
    assert {joint.velocity for joint in model.joints} == {4.0}
    for joint in model.joints:
        if joint.name.endswith("hip_yaw"):
            outward = joint.name[:2] in ("fl", "rr")
            assert (joint.lower, joint.upper) == ((-0.3927, 1.5708) if outward else (-1.5708, 0.3927))


@pytest.mark.parametrize("name", CATALOGUE)
def test_feet_at_zero_are_where_the_table_says(name: str) -> None:
    """At zero the leg is folded: hip 0.13 and upper leg 0.222 outwards along x, lower leg 0.305 back."""
    model = catalogue.load(name)
    reach = 0.15121 + 0.13 + 0.222 - 0.305
    for foot, (x, y) in {"fl": (1, 1), "rl": (-1, 1), "fr": (1, -1), "rr": (-1, -1)}.items():
        position = np.asarray(kinematics.foot_position(model, foot, np.zeros(model.size))).ravel()
        np.testing.assert_allclose(position, [x * reach, y * 0.15121, 0.0], atol=1e-15)


@pytest.mark.parametrize("name", CATALOGUE)
def test_straight_leg_reaches_its_full_length(name: str) -> None:
    model = catalogue.load(name)
    q = np.zeros(model.size)
    q[[model.coordinate_index(f"{leg}_knee") for leg in model.foot_names]] = np.pi
    for foot in model.foot_names:
        position = np.asarray(kinematics.foot_position(model, foot, q)).ravel()
        assert abs(position[0]) == pytest.approx(0.15121 + 0.13 + 0.222 + 0.305, abs=1e-15)


@pytest.mark.parametrize("name", CATALOGUE)
def test_posture_stands_on_four_sprawled_legs(name: str) -> None:
    model, posture = catalogue.load(name), catalogue.posture(name)
    q = posture.coordinates(model)
    feet = np.array([np.asarray(kinematics.foot_position(model, foot, q)).ravel() for foot in model.foot_names])
    assert np.ptp(feet[:, 2]) < 1e-12
    assert np.abs(feet[:, 2]).max() < 0.01  # the angles are known to two digits
    hips = 0.15121
    assert (np.abs(feet[:, :2]) > hips + 0.05).all()  # each foot well outside its hip in both directions
    np.testing.assert_allclose(model.mirror.position(q), q, atol=1e-15)
    for joint in model.joints:
        assert joint.lower < posture.angles[joint.name] < joint.upper


@pytest.mark.parametrize("name", CATALOGUE)
def test_bounds_hold_the_posture_and_are_mirrored(name: str) -> None:
    model, bounds, posture = catalogue.load(name), catalogue.bounds(name), catalogue.posture(name)
    assert set(bounds.positions) == {*model.coordinate_names} - {"x", "y"}
    for joint in model.joint_names:
        lower, upper = bounds.positions[joint]
        assert lower < posture.angles[joint] < upper
    corners = np.array([bounds.positions.get(c, (-1.0, 1.0)) for c in model.coordinate_names])
    image = model.mirror.position(corners)
    np.testing.assert_allclose(np.sort(image, axis=1), corners, atol=1e-15)


@pytest.mark.parametrize("name", CATALOGUE)
def test_bounds_of_the_hip_yaw_turn_legs_outwards(name: str) -> None:
    model, bounds = catalogue.load(name), catalogue.bounds(name)
    for foot in model.foot_names:
        q = catalogue.posture(name).coordinates(model)
        index = model.coordinate_index(f"{foot}_hip_yaw")
        widths = []
        for yaw in sorted(bounds.positions[f"{foot}_hip_yaw"], key=abs):
            q[index] = yaw
            widths.append(abs(float(kinematics.foot_position(model, foot, q)[1])))
        assert widths[0] == pytest.approx(0.15121, abs=1e-12)
        assert widths[1] > widths[0] + 0.1
