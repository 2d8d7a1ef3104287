"""Factorisations as expressions, against numpy."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from amble.maths.linear_algebra import SymmetricFactor, solve_square
from amble.types import Matrix

SIZES = [1, 2, 5, 12]


def matrices(size: int, seed: int = 0) -> tuple[Matrix, Matrix]:
    generator = np.random.default_rng([seed, size])
    return generator.normal(size=(size, size)), generator.normal(size=(size, 3))


def evaluated(build: Callable[..., list[ca.SX]], *values: Matrix) -> list[Matrix]:
    symbols = [ca.SX.sym("m", *value.shape) for value in values]
    results = ca.Function("f", symbols, build(*symbols))(*values)
    return [np.asarray(result) for result in (results if isinstance(results, tuple) else [results])]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("seed", range(5))
def test_symmetric_solve_equals_numpy(size: int, seed: int) -> None:
    root, right = matrices(size, seed)
    matrix = root @ root.T + 0.1 * np.eye(size)
    order = list(np.random.default_rng(seed).permutation(size))

    def build(a: ca.SX, b: ca.SX) -> list[ca.SX]:
        factor = SymmetricFactor.of(a, [int(place) for place in order])
        return [factor.solve(b), factor.pivots, SymmetricFactor.of(a).solve(b)]

    ours, pivots, natural = evaluated(build, matrix, right)
    expected = np.linalg.solve(matrix, right)
    rounding = 1e-14 * np.linalg.cond(matrix) * np.abs(expected).max()  # backward stable: condition times rounding
    np.testing.assert_allclose(ours, expected, atol=rounding)
    np.testing.assert_allclose(natural, expected, atol=rounding)
    assert pivots.min() > 0.0
    assert np.prod(pivots) == pytest.approx(np.linalg.det(matrix), rel=1e-10)


def test_symmetric_factor_keeps_an_arrow_sparse() -> None:
    """Eliminated from the tips inwards, an arrow matrix fills nothing."""
    size = 8
    pattern = ca.DM.eye(size)
    pattern[0, :] = pattern[:, 0] = 1.0
    matrix = ca.SX.sym("a", pattern.sparsity())
    fill = SymmetricFactor.of(matrix, range(size - 1, -1, -1)).lower.nnz()
    assert fill == size - 1
    assert SymmetricFactor.of(matrix).lower.nnz() == size * (size - 1) // 2


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("seed", range(5))
def test_square_solve_equals_numpy(size: int, seed: int) -> None:
    matrix, right = matrices(size, seed)

    def build(a: ca.SX, b: ca.SX) -> list[ca.SX]:
        solution = solve_square(a, b)
        return [solution.value, solution.pivots]

    ours, pivots = evaluated(build, matrix, right)
    expected = np.linalg.solve(matrix, right)
    rounding = 1e-14 * np.linalg.cond(matrix) * np.abs(expected).max()
    np.testing.assert_allclose(ours, expected, atol=rounding)
    assert np.prod(pivots) == pytest.approx(abs(np.linalg.det(matrix)), rel=1e-10)
    assert pivots.min() >= np.linalg.svd(matrix, compute_uv=False)[-1] * (1.0 - 1e-12)


def test_square_solve_needs_no_pivoting() -> None:
    """A zero on the diagonal stops elimination without row exchanges, not reflections."""
    matrix = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    (ours,) = evaluated(lambda a, b: [solve_square(a, b).value], matrix, np.eye(3))
    np.testing.assert_allclose(ours, np.linalg.inv(matrix), atol=1e-15)


def test_smallest_pivot_tells_a_lost_rank() -> None:
    matrix, right = matrices(6)
    matrix[3] = matrix[0] - 2.0 * matrix[5]
    pivots = evaluated(lambda a, b: [solve_square(a, b).pivots], matrix, right)[0]
    assert pivots.min() < 1e-14 * np.abs(matrix).max() * 10.0  # rounding of six terms
