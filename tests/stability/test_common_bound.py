"""One quadratic function for several maps: families whose best rate is known, and a semidefinite program."""

from __future__ import annotations

from itertools import product

import cvxpy as cp
import numpy as np
import pytest

from amble.stability.common_bound import common_bound, smoothed_norm
from amble.types import Matrix


def turned(seed: int, size: int, count: int, rate: float, spread: float = 1.0) -> list[Matrix]:
    """Rotations times a rate, seen in one skew coordinate system: the joint spectral radius is that rate."""
    draw = np.random.default_rng(seed)
    skew = draw.normal(size=(size, size)) @ np.diag(10.0 ** draw.uniform(-spread, spread, size))
    turns = [np.linalg.qr(draw.normal(size=(size, size)))[0] for _ in range(count)]
    return [skew @ (rate * turn) @ np.linalg.inv(skew) for turn in turns]


@pytest.mark.parametrize(("size", "count"), [(2, 2), (5, 3), (33, 2), (12, 24)])
@pytest.mark.parametrize("rate", [0.2, 0.9])
def test_the_ellipsoid_of_a_known_family_is_found(size: int, count: int, rate: float) -> None:
    found = common_bound(turned(size, size, count, rate, spread=0.5))
    assert found.verified
    assert rate <= found.rate < 1.002 * rate  # no norm gives less than the joint spectral radius


def feasible(matrices: list[Matrix], rate: float) -> bool:
    """Whether a semidefinite program finds W > 0 with r^2 W - A^T W A > 0 for all A."""
    size = len(matrices[0])
    W = cp.Variable((size, size), symmetric=True)
    margin = 1e-6 * np.eye(size)
    rows = [W >> np.eye(size), *(rate**2 * W - matrix.T @ W @ matrix >> margin for matrix in matrices)]
    problem = cp.Problem(cp.Minimize(cp.trace(W)), rows)
    problem.solve(solver=cp.CLARABEL)
    return problem.status == cp.OPTIMAL


@pytest.mark.parametrize("seed", range(4))
def test_no_semidefinite_program_finds_a_smaller_rate(seed: int) -> None:
    draw = np.random.default_rng(seed)
    matrices = [0.3 * draw.normal(size=(5, 5)) for _ in range(3)]
    found = common_bound(matrices)
    assert found.verified
    assert feasible(matrices, 1.01 * found.rate)
    assert not feasible(matrices, 0.99 * found.rate)


@pytest.mark.parametrize("seed", range(4))
def test_every_product_is_bounded(seed: int) -> None:
    draw = np.random.default_rng(seed)
    matrices = [0.4 * draw.normal(size=(6, 6)) for _ in range(2)]
    found = common_bound(matrices)
    for word in product(matrices, repeat=6):
        chain = np.linalg.multi_dot(word)
        assert np.abs(np.linalg.eigvals(chain)).max() <= found.rate ** len(word)
    x = draw.normal(size=(50, 6))
    values = np.einsum("ki,ij,kj->k", x, found.metric, x)
    for matrix in matrices:
        after = x @ matrix.T
        assert np.all(np.einsum("ki,ij,kj->k", after, found.metric, after) < found.rate**2 * values)


def test_maps_that_are_stable_each_and_not_in_turn_have_no_rate_below_one() -> None:
    shear, other = np.array([[0.1, 2.0], [0.0, 0.1]]), np.array([[0.1, 0.0], [2.0, 0.1]])
    assert max(np.abs(np.linalg.eigvals(matrix)).max() for matrix in (shear, other)) < 0.2
    assert common_bound([shear, other]).rate >= np.sqrt(np.abs(np.linalg.eigvals(shear @ other)).max()) > 1.0


@pytest.mark.parametrize("matrix", [np.zeros((3, 3)), np.diag([1.0, 1.0], 1), 1e-12 * np.eye(3)])
def test_maps_that_vanish_have_a_verified_rate(matrix: Matrix) -> None:
    found = common_bound([matrix, matrix])
    assert found.verified
    assert 0.0 < found.rate < 1.0


def test_states_of_very_different_size_are_verified() -> None:
    scales = np.exp(np.random.default_rng(3).normal(scale=8.0, size=10))
    matrices = [matrix * np.outer(scales, 1.0 / scales) for matrix in turned(4, 10, 2, 0.7)]
    found = common_bound(matrices)
    assert found.verified
    assert found.rate < 0.702


@pytest.mark.parametrize(("size", "step"), [(6, 1e3), (12, 1e4), (20, 1e6)])
def test_maps_that_magnify_long_before_they_shrink_have_a_verified_bound(size: int, step: float) -> None:
    """Jordan blocks with large steps: of the metrics that see their radius none can be factored."""
    turn = np.linalg.qr(np.random.default_rng(size).normal(size=(size, size)))[0]
    chain = np.diag(np.full(size - 1, step), 1)
    maps = [turn @ (chain + share * np.eye(size)) @ turn.T for share in (0.5, -0.3)]
    found = common_bound(maps)
    assert found.verified
    assert 0.5 < found.rate <= 1.01 * max(np.linalg.norm(matrix, 2) for matrix in maps)


@pytest.mark.parametrize("exponent", [2, 16])
def test_the_smoothed_norm_has_the_slopes_of_its_differences(exponent: int) -> None:
    """In L and in every map; central differences of 1e-6 are good to about 1e-9."""
    draw = np.random.default_rng(exponent)
    root, *maps = draw.normal(size=(4, 5, 5))
    value, in_root, in_maps = smoothed_norm(root, maps, exponent)
    seen = [root @ matrix @ np.linalg.inv(root) for matrix in maps]
    assert value >= np.log(max(np.linalg.norm(matrix, 2) for matrix in seen))
    for place, slope in enumerate((in_root, *in_maps)):
        direction = draw.normal(size=(5, 5))
        ends = []
        for side in (-1e-6, 1e-6):
            moved = [root, *maps]
            moved[place] = moved[place] + side * direction
            ends.append(smoothed_norm(moved[0], moved[1:], exponent)[0])
        assert (ends[1] - ends[0]) / 2e-6 == pytest.approx(float(np.sum(slope * direction)), rel=1e-6, abs=1e-8)
