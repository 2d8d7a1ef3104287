"""The mirror: a group element of order two under which the dynamics are invariant."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.robot import Link, Robot, dynamics, kinematics, symmetrized
from amble.robot.mirror import REFLECTION
from amble.types import frozen
from tests.robots import CATALOGUE, ROBOTS, random_states, robot


def exactly_symmetric(name: str) -> Robot:
    return robot(name) if name in CATALOGUE else symmetrized(robot(name))


@pytest.mark.parametrize("name", ROBOTS)
def test_mirror_is_its_own_inverse(name: str) -> None:
    model = robot(name)
    generator = np.random.default_rng(0)
    for mirror, size in (
        (model.mirror.position, model.size),
        (model.mirror.state, 2 * model.size),
        (model.mirror.torque, len(model.joints)),
        (model.mirror.force, 3 * len(model.feet)),
    ):
        values = generator.normal(size=size)
        np.testing.assert_array_equal(mirror(mirror(values)), values)
        assert not np.array_equal(mirror(values), values)
    assert {twin: foot for foot, twin in model.mirror.feet.items()} == dict(model.mirror.feet)


@pytest.mark.parametrize("name", ROBOTS)
def test_dynamics_commute_with_the_mirror(name: str) -> None:
    """Inverse dynamics, feet and their forces: what the mirror does before or after is the same."""
    model = exactly_symmetric(name)
    mirror = model.mirror
    q, v = random_states(model, 20, seed=1)
    a = random_states(model, 20, seed=2)[1]
    for pose, rate, acceleration in zip(q, v, a, strict=True):
        images = [mirror.position(each) for each in (pose, rate, acceleration)]
        forces = np.asarray(dynamics.inverse_dynamics(model, pose, rate, acceleration)).ravel()
        mirrored = np.asarray(dynamics.inverse_dynamics(model, *images)).ravel()
        # roundings of two evaluations of about a thousand operations
        np.testing.assert_allclose(mirrored, mirror.position(forces), atol=1e-12 * np.abs(forces).max())
        for foot, twin in mirror.feet.items():
            image = np.asarray(kinematics.foot_bias(model, twin, *images[:2])).ravel()
            original = np.asarray(kinematics.foot_bias(model, foot, pose, rate)).ravel()
            np.testing.assert_allclose(image, REFLECTION @ original, atol=1e-12 * np.abs(original).max())


@pytest.mark.parametrize("name", ROBOTS)
def test_contact_forces_do_the_same_work_mirrored(name: str) -> None:
    """The generalised forces J' f of mirrored forces at the mirrored pose are the mirrored generalised forces."""
    model = robot(name)
    generator = np.random.default_rng(3)
    pose, force = random_states(model, 1, seed=3)[0][0], generator.normal(size=3 * len(model.feet))

    def generalised(q: np.ndarray, f: np.ndarray) -> np.ndarray:
        jacobian = np.vstack([np.asarray(kinematics.foot_jacobian(model, foot, q)) for foot in model.foot_names])
        return jacobian.T @ f

    mirrored = generalised(model.mirror.position(pose), model.mirror.force(force))
    np.testing.assert_allclose(mirrored, model.mirror.position(generalised(pose, force)), atol=1e-12)


@pytest.mark.parametrize("name", CATALOGUE)
def test_signs_and_twins_of_astro(name: str) -> None:
    model = robot(name)
    q = np.arange(1.0, 19.0)
    image = dict(zip(model.coordinate_names, model.mirror.position(q), strict=True))
    own = dict(zip(model.coordinate_names, q, strict=True))
    assert dict(model.mirror.feet) == {"fl": "fr", "fr": "fl", "rl": "rr", "rr": "rl"}
    for coordinate, sign in (("x", 1), ("y", -1), ("z", 1), ("roll", -1), ("pitch", 1), ("yaw", -1)):
        assert image[coordinate] == sign * own[coordinate]
    for left, right in (("fl", "fr"), ("rl", "rr")):
        assert image[f"{right}_hip_yaw"] == -own[f"{left}_hip_yaw"]
        assert image[f"{right}_hip_pitch"] == own[f"{left}_hip_pitch"]
        assert image[f"{right}_knee"] == own[f"{left}_knee"]


@pytest.mark.parametrize("kind", [ca.SX, ca.MX, ca.DM])
def test_casadi_values_mirror_as_numbers_do(kind: type) -> None:
    mirror = robot("astro").mirror
    for apply, size in ((mirror.position, 18), (mirror.state, 36), (mirror.torque, 12), (mirror.force, 12)):
        values = np.random.default_rng(4).normal(size=size)
        if kind is ca.DM:
            ours = apply(ca.DM(values))
        else:
            symbol = kind.sym("a", size)
            ours = ca.Function("mirror", [symbol], [apply(symbol)])(values)
        np.testing.assert_array_equal(np.asarray(ours).ravel(), apply(values))


def test_columns_mirror_one_by_one() -> None:
    mirror = robot("astro").mirror
    values = np.random.default_rng(5).normal(size=(18, 3))
    expected = np.stack([mirror.position(column) for column in values.T], axis=1)
    np.testing.assert_array_equal(mirror.position(values), expected)
    np.testing.assert_array_equal(np.asarray(mirror.position(ca.DM(values))), expected)


def heavier(model: Robot, link: int, factor: float) -> Robot:
    links = list(model.links)
    old = links[link]
    links[link] = Link(old.name, old.mass * factor, old.center, frozen(old.inertia * factor))
    return replace(model, links=tuple(links))


def test_asymmetric_robot_has_no_mirror() -> None:
    lopsided = heavier(robot("astro"), 1, 1.01)
    with pytest.raises(InputError, match="not left-right symmetric: the mass matrix deviates"):
        _ = lopsided.mirror
    tolerant = replace(lopsided, symmetry_tolerance=0.05)
    assert 1e-4 < tolerant.mirror.asymmetry < 0.01
    assert symmetrized(lopsided).mirror.asymmetry < 1e-12
    assert symmetrized(lopsided).mass == pytest.approx(lopsided.mass, rel=1e-14)


def test_feet_without_twins_are_named() -> None:
    with pytest.raises(InputError, match=r"without a left-right twin \(rl, rr\)"):
        _ = replace(robot("astro"), twins=(("fl", "fr"),)).mirror
    with pytest.raises(InputError, match="'fl' twice"):
        _ = replace(robot("astro"), twins=(("fl", "fr"), ("fl", "rr"))).mirror


def test_wrong_twins_are_refused() -> None:
    """Front and rear legs are no left-right twins: their hips do not mirror each other."""
    with pytest.raises(InputError, match="not left-right symmetric"):
        _ = replace(robot("astro"), twins=(("fl", "rl"), ("fr", "rr"))).mirror
