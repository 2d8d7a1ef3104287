"""Averaging left and right: exact afterwards, in inertia and geometry, and idempotent."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError
from amble.robot import Robot, load_robot, symmetrized
from amble.robot.rotation import rotation_about
from amble.types import frozen
from tests.quadruped import FEET, write
from tests.robots import ROBOTS, robot


def bent(model: Robot, size: float, seed: int) -> Robot:
    """Move and turn every joint and foot a little, each side on its own."""
    generator = np.random.default_rng(seed)

    def turn() -> np.ndarray:
        axis = generator.normal(size=3)
        return np.asarray(rotation_about(axis / np.linalg.norm(axis), size))

    return replace(
        model,
        joints=tuple(
            replace(
                joint,
                translation=frozen(joint.translation + size * generator.normal(size=3)),
                rotation=frozen(joint.rotation @ turn()),
                lower=joint.lower + size * generator.normal(),
            )
            for joint in model.joints
        ),
        feet=tuple(replace(foot, offset=frozen(foot.offset + size * generator.normal(size=3))) for foot in model.feet),
    )


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("size", [7.5e-5, 3e-3])
def test_geometry_is_averaged_too(name: str, size: float) -> None:
    """B2's feet are 7.5e-5 apart, which no averaging of inertias mends."""
    uneven = bent(robot(name), size, seed=1)
    with pytest.raises(InputError, match="not left-right symmetric"):
        _ = replace(uneven, symmetry_tolerance=1e-9).mirror
    even = symmetrized(uneven)
    assert even.mirror.asymmetry < 1e-13
    assert even.mass == pytest.approx(uneven.mass, rel=1e-14)
    index, sign = even.mirror.joints.index, even.mirror.joints.sign
    for j, joint in enumerate(even.joints):
        twin = even.joints[int(index[j])]
        other = (twin.lower, twin.upper) if sign[j] > 0 else (-twin.upper, -twin.lower)
        assert (joint.lower, joint.upper) == other
        assert joint.lower >= uneven.joints[j].lower


@pytest.mark.parametrize("name", ROBOTS)
def test_a_symmetric_robot_stays_what_it_is(name: str) -> None:
    once = symmetrized(robot(name))
    twice = symmetrized(once)
    for one, other in zip(once.joints, twice.joints, strict=True):
        np.testing.assert_allclose(other.translation, one.translation, atol=1e-16)
        np.testing.assert_allclose(other.rotation, one.rotation, atol=1e-15)
    for one, other in zip(once.links, twice.links, strict=True):
        np.testing.assert_allclose(other.inertia, one.inertia, rtol=1e-13, atol=1e-17)


def test_what_is_no_twin_is_not_averaged(tmp_path: Path) -> None:
    walker = load_robot(write(tmp_path), FEET)
    with pytest.raises(InputError, match=r"leg lengths from the mirror image of its twin; are the twins named right"):
        symmetrized(replace(walker, twins=(("fl", "rr"), ("fr", "rl"))))
    with pytest.raises(InputError, match=r"are the twins named right, and does the base have x forward and z up"):
        _ = replace(walker, twins=(("fl", "rr"), ("fr", "rl"))).mirror
    moved = [replace(walker.joints[0], lower=1.0, upper=2.0), *walker.joints[1:]]
    with pytest.raises(InputError, match="joint 'lf_hx' moves from 1 to 2 rad, its twin 'rf_hx' mirrored from"):
        symmetrized(replace(walker, joints=(*moved[:3], replace(moved[3], lower=1.0, upper=2.0), *moved[4:])))
