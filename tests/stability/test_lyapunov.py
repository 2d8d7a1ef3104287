"""The smoothed spectral radius: its equation, its bounds and its slope, on random matrices and on known ones."""

from __future__ import annotations

import itertools

import cvxpy as cp
import numpy as np
import pytest
from scipy.linalg import solve_discrete_lyapunov

from amble.errors import InputError
from amble.stability.lyapunov import accumulated, smoothed_radius
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
