"""The verified contraction bound: what it promises holds, and what does not hold is not verified."""

from __future__ import annotations

import numpy as np
import pytest

from amble.residual import Residual
from amble.stability.quadratic_bound import least_eigenvalue_bound, quadratic_bound, verified_bound
from amble.types import Matrix


def stable(seed: int, radius: float, size: int = 20) -> Matrix:
    generator = np.random.default_rng(seed)
    scales = np.exp(generator.normal(scale=2.0, size=size))
    matrix = generator.normal(size=(size, size)) * np.outer(scales, 1.0 / scales)
    return matrix * radius / np.abs(np.linalg.eigvals(matrix)).max()


@pytest.mark.parametrize("radius", [1e-3, 0.3, 0.9, 0.999])
@pytest.mark.parametrize("seed", range(3))
def test_v_falls_by_the_rate(seed: int, radius: float) -> None:
    matrix = stable(seed, radius)
    found = quadratic_bound(matrix)
    assert radius < found.rate < 1.0
    assert all(row.violation == 0.0 for row in found.rows())
    points = np.random.default_rng(seed).normal(size=(200, len(matrix)))
    after = points @ matrix.T
    values, later = (np.einsum("ki,ij,kj->k", x, found.metric, x) for x in (points, after))
    assert np.all(later < found.rate**2 * values)


@pytest.mark.parametrize("seed", range(5))
def test_states_of_very_different_size_are_verified(seed: int) -> None:
    """Angles beside rates of a robot of 5 cm: in the states' own units the inequality drowns in its rounding."""
    generator = np.random.default_rng(seed)
    scales = np.exp(generator.normal(scale=10.0, size=12))
    matrix = stable(seed, 0.9, 12) * np.outer(scales, 1.0 / scales)
    found = quadratic_bound(matrix)
    assert all(row.violation == 0.0 for row in found.rows())
    assert verified_bound(matrix, found.rate, found.metric).decrease < 0.0  # not because it is easy


def test_w_that_does_not_decrease_is_not_verified() -> None:
    matrix = np.array([[0.5, 3.0], [0.0, 0.5]])
    found = verified_bound(matrix, 0.9, np.eye(2))
    assert found.definite > 0.0
    assert found.decrease < 0.0
    assert [row.name for row in found.rows() if row.violation > 0.0] == ["least eigenvalue of r^2 W - A^T W A"]
    assert verified_bound(matrix, 0.9, np.diag([1.0, -1.0])).definite < 0.0
    # one that does: the root of its equation, and half of what is left taken away turns the verdict
    good = quadratic_bound(matrix)
    assert good.decrease > 0.0
    assert verified_bound(matrix, 0.49, good.metric).decrease < 0.0


@pytest.mark.parametrize("seed", range(5))
def test_least_eigenvalue_is_bounded_from_below_and_seen(seed: int) -> None:
    """For condition 1e6: never above the true one, and at least the quarter of it that the margin is meant to leave."""
    generator = np.random.default_rng(seed)
    turn = np.linalg.qr(generator.normal(size=(15, 15)))[0]
    values = np.geomspace(1.0, 1e6, 15)
    matrix = (turn * values) @ turn.T
    bound = least_eigenvalue_bound(0.5 * (matrix + matrix.T))
    assert 0.25 < bound < 1.0
    values[0] = -1e-3
    assert least_eigenvalue_bound((turn * values) @ turn.T) <= 0.0


def test_rounding_decides_where_nothing_is_left() -> None:
    """Of condition 1e20 no sign of the least eigenvalue is known."""
    turn = np.linalg.qr(np.random.default_rng(0).normal(size=(6, 6)))[0]
    matrix = (turn * np.geomspace(1e-20, 1.0, 6)) @ turn.T
    assert least_eigenvalue_bound(0.5 * (matrix + matrix.T)) <= 0.0


def test_a_map_onto_the_orbit_has_a_bound() -> None:
    found = quadratic_bound(np.zeros((3, 3)))
    assert 0.0 < found.rate < 1.0
    assert all(row.violation == 0.0 for row in found.rows())


def test_it_says_what_it_is_in_json() -> None:
    found = quadratic_bound(np.diag([0.5, 0.2]))
    tree = found.to_dict()
    assert tree["rate"] == found.rate
    assert np.array(tree["W"]).shape == (2, 2)
    assert isinstance(found.rows()[0], Residual)
