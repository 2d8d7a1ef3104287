"""Rotations of files and joints."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from amble.robot.rotation import rotation_about, rotation_of_rpy, skew, snap


@pytest.mark.parametrize("seed", range(5))
def test_rotations_equal_scipy(seed: int) -> None:
    generator = np.random.default_rng(seed)
    angles, axis = generator.uniform(-3.0, 3.0, 3), generator.normal(size=3)
    axis /= np.linalg.norm(axis)
    np.testing.assert_allclose(rotation_of_rpy(angles), Rotation.from_euler("xyz", angles).as_matrix(), atol=1e-15)
    ours = np.asarray(rotation_about(axis, angles[0]))
    np.testing.assert_allclose(ours, Rotation.from_rotvec(angles[0] * axis).as_matrix(), atol=1e-15)
    np.testing.assert_allclose(skew(axis) @ angles, np.cross(axis, angles), atol=1e-15)


def test_twelve_digits_of_pi_are_half_a_turn() -> None:
    np.testing.assert_array_equal(rotation_of_rpy(np.array([0.0, 0.0, 3.14159265359])), np.diag([-1.0, -1.0, 1.0]))


def test_snap_leaves_what_is_meant() -> None:
    """3.1416 is a written angle, not a rounded half turn."""
    assert rotation_of_rpy(np.array([0.0, 0.0, 3.1416]))[0, 1] == pytest.approx(7.3464e-6, rel=1e-4)
    np.testing.assert_array_equal(snap(np.array([0.5, 1e-11, 1.0 - 1e-11])), [0.5, 1e-11, 1.0 - 1e-11])
