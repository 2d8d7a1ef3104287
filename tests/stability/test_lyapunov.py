"""The smoothed spectral radius: its equation, its bounds and its slope, on random matrices and on known ones."""

from __future__ import annotations

import itertools

import cvxpy as cp
import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from amble.errors import InputError
from amble.residual import Residual
from amble.stability import lyapunov
from amble.stability.lyapunov import (
    accumulated,
    least_eigenvalue_bound,
    quadratic_bound,
    smoothed_radius,
    verified_bound,
)
from amble.types import Matrix

SEEDS = range(6)


def far_from_normal(seed: int, size: int = 12) -> Matrix:
    """Rows and columns of sizes from 0.05 to 20, as states in different units have."""
    generator = np.random.default_rng(seed)
    scales = np.exp(generator.normal(size=size))
    return generator.normal(size=(size, size)) * np.outer(scales, 1.0 / scales)


def radius(matrix: Matrix) -> float:
    return float(np.abs(np.linalg.eigvals(matrix)).max())


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize("trace", [1e2, 1e5])
def test_w_solves_its_equation_with_the_trace_asked_for(seed: int, trace: float) -> None:
    """Against a direct solution of scipy; its error is about trace^2 eps relative to entries up to the trace."""
    matrix = far_from_normal(seed)
    found = smoothed_radius(matrix, trace)
    assert found.value > radius(matrix)
    assert np.trace(found.metric) == pytest.approx(trace, rel=1e-6)  # slope of the trace times the root's 1e-12
    expected = solve_discrete_lyapunov(matrix.T / found.value, np.eye(len(matrix)))
    assert np.allclose(found.metric, expected, rtol=0.0, atol=1e-8 * trace)
    assert np.linalg.eigvalsh(found.metric).min() >= 1.0 - 1e-9 * trace


@pytest.mark.parametrize("seed", SEEDS)
def test_slope_is_that_of_central_differences(seed: int) -> None:
    """The step 1e-5 leaves its square times a third derivative, and the root's 1e-12 over the step."""
    matrix = far_from_normal(seed)
    direction = np.random.default_rng(seed + 100).normal(size=matrix.shape)
    step = 1e-5
    ahead, behind = (np.log(smoothed_radius(matrix + sign * step * direction, 1e3).value) for sign in (1.0, -1.0))
    slope = smoothed_radius(matrix, 1e3).slope
    assert (ahead - behind) / (2.0 * step) == pytest.approx(float(np.sum(slope * direction)), rel=1e-5, abs=1e-6)


@pytest.mark.parametrize("seed", SEEDS)
def test_it_falls_to_the_radius_as_the_trace_grows(seed: int) -> None:
    matrix = far_from_normal(seed)
    values = [smoothed_radius(matrix, trace).value for trace in (1e2, 1e4, 1e6, 1e8)]
    assert all(later < earlier for earlier, later in itertools.pairwise(values))
    # above the radius by about its condition over 2 c: a condition below 1e4 for these matrices
    assert radius(matrix) < values[-1] < radius(matrix) * (1.0 + 1e-4)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_matrix_and_its_transpose_have_the_same(seed: int) -> None:
    """Both traces are the sum of |A^k / s^k|_F^2; the slope is transposed too, and <slope, A> = 1."""
    matrix = far_from_normal(seed)
    one, other = smoothed_radius(matrix, 1e4), smoothed_radius(matrix.T, 1e4)
    assert one.value == pytest.approx(other.value, rel=1e-10)
    assert np.allclose(one.slope, other.slope.T, rtol=1e-6, atol=1e-6 * np.abs(one.slope).max())
    assert np.sum(one.slope * matrix) == pytest.approx(1.0)
    assert smoothed_radius(3.0 * matrix, 1e4).value == pytest.approx(3.0 * one.value, rel=1e-10)


@pytest.mark.parametrize("seed", SEEDS)
def test_powers_keep_to_the_growth_it_promises(seed: int) -> None:
    matrix = far_from_normal(seed)
    found = smoothed_radius(matrix, 1e3)
    for power in range(1, 30):
        size = np.linalg.norm(np.linalg.matrix_power(matrix / found.value, power), 2)
        assert size <= np.sqrt(1e3) * (1.0 + 1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_a_semidefinite_program_finds_the_same_trace(seed: int) -> None:
    """The solution of the equation is the least W of the inequality: Clarabel's least trace, to its accuracy."""
    matrix = np.random.default_rng(seed).normal(size=(5, 5))
    found = smoothed_radius(matrix, 50.0)
    scaled = matrix / found.value
    metric = cp.Variable((5, 5), symmetric=True)
    problem = cp.Problem(cp.Minimize(cp.trace(metric)), [metric - scaled.T @ metric @ scaled >> np.eye(5)])
    assert float(problem.solve(solver=cp.CLARABEL)) == pytest.approx(50.0, rel=1e-5)


def test_known_maps() -> None:
    """A number a: 1 / (1 - (a / s)^2) = c. A shift of two states: trace 2 + 1 / s^2, although the radius is 0."""
    assert smoothed_radius(np.array([[-0.5]]), 100.0).value == pytest.approx(0.5 / np.sqrt(0.99))
    assert smoothed_radius(np.array([[0.0, 1.0], [0.0, 0.0]]), 102.0).value == pytest.approx(0.1)
    turn = np.array([[0.0, -0.8], [0.8, 0.0]])
    assert smoothed_radius(turn, 200.0).value == pytest.approx(0.8 / np.sqrt(0.99))


def test_a_sum_that_diverges_is_infinite() -> None:
    assert np.all(np.isinf(accumulated(np.array([[1.01, 0.0], [0.3, 0.2]]))))
    assert np.all(np.isinf(accumulated(np.array([[1e200]]))))


def test_what_has_no_smoothed_radius_is_refused() -> None:
    for matrix in (np.zeros((2, 2)), np.array([[np.nan]])):
        with pytest.raises(InputError, match="finite matrix which is not zero"):
            smoothed_radius(matrix, 1e3)
    with pytest.raises(InputError, match="above 2, the size"):
        smoothed_radius(np.eye(2), 2.0)


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


@pytest.mark.parametrize("seed", SEEDS)
def test_the_native_sum_is_that_of_numpy(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """A tenth above the radius, where it loses no digits, and below it, where it diverges."""
    matrix = far_from_normal(seed)
    scaled = matrix / (1.1 * radius(matrix)), matrix / (0.9 * radius(matrix))
    found = [lyapunov._accumulated_both(one) for one in scaled]
    monkeypatch.setattr(lyapunov, "numerical", lambda _: None)
    for one, other in zip(found, map(lyapunov._accumulated_both, scaled), strict=True):
        assert all(np.allclose(*pair, rtol=1e-10) for pair in zip(one, other, strict=True))
    assert np.all(np.isinf(found[1]))
