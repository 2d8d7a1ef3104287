"""Factorisations as expressions, against numpy."""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca
import numpy as np
import pytest

from amble.numerics.linear_algebra import OrthogonalFactor, SymmetricFactor
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
        factor = OrthogonalFactor.of(a)
        return [factor.solve(b), factor.pivots]

    ours, pivots = evaluated(build, matrix, right)
    expected = np.linalg.solve(matrix, right)
    rounding = 1e-14 * np.linalg.cond(matrix) * np.abs(expected).max()
    np.testing.assert_allclose(ours, expected, atol=rounding)
    assert np.prod(pivots) == pytest.approx(abs(np.linalg.det(matrix)), rel=1e-10)
    assert pivots.min() >= np.linalg.svd(matrix, compute_uv=False)[-1] * (1.0 - 1e-12)


def test_square_solve_needs_no_pivoting() -> None:
    """A zero on the diagonal stops elimination without row exchanges, not reflections."""
    matrix = np.array([[0.0, 1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 2.0]])
    (ours,) = evaluated(lambda a, b: [OrthogonalFactor.of(a).solve(b)], matrix, np.eye(3))
    np.testing.assert_allclose(ours, np.linalg.inv(matrix), atol=1e-15)


def test_smallest_pivot_tells_a_lost_rank() -> None:
    matrix, _ = matrices(6)
    matrix[3] = matrix[0] - 2.0 * matrix[5]
    pivots = evaluated(lambda a: [OrthogonalFactor.of(a).pivots], matrix)[0]
    assert pivots.min() < 1e-14 * np.abs(matrix).max() * 10.0  # rounding of six terms


@pytest.mark.parametrize(("rows", "columns"), [(1, 4), (3, 4), (5, 12), (11, 15)])
@pytest.mark.parametrize("seed", range(5))
def test_wide_solve_is_the_shortest_and_the_kernel_is_complete(rows: int, columns: int, seed: int) -> None:
    generator = np.random.default_rng([seed, rows])
    matrix, right = generator.normal(size=(rows, columns)), generator.normal(size=(rows, 2))

    def build(a: ca.SX, b: ca.SX) -> list[ca.SX]:
        factor = OrthogonalFactor.of(a)
        return [factor.solve(b), ca.densify(factor.kernel), factor.pivots]

    ours, kernel, pivots = evaluated(build, matrix, right)
    expected = np.linalg.pinv(matrix) @ right
    np.testing.assert_allclose(ours, expected, atol=1e-14 * np.linalg.cond(matrix) * np.abs(expected).max())
    assert kernel.shape == (columns, columns - rows)
    # a few roundings of unit vectors
    np.testing.assert_allclose(matrix @ kernel, 0.0, atol=1e-13 * np.abs(matrix).max())
    np.testing.assert_allclose(kernel.T @ kernel, np.eye(columns - rows), atol=1e-14)
    assert pivots.min() >= np.linalg.svd(matrix, compute_uv=False)[-1] * (1.0 - 1e-12)


def test_orthogonal_factor_keeps_zeros() -> None:
    """Rows that share no column are reflected without touching each other."""
    blocks = ca.diagcat(ca.SX.sym("a", 2, 3), ca.SX.sym("b", 2, 4))
    assert OrthogonalFactor.of(blocks).lower.nnz() == 6


def test_a_row_of_zeros_has_no_pivot_and_leaves_the_others_numbers() -> None:
    matrix = np.array([[1.0, 2.0, 0.0], [0.0, 0.0, 0.0]])
    kernel, pivots = evaluated(lambda a: [OrthogonalFactor.of(a).kernel, OrthogonalFactor.of(a).pivots], matrix)
    assert np.isfinite(kernel).all()
    assert pivots.min() == 0.0


def test_sines_have_no_units() -> None:
    """The sine of a row is its distance from the span of the rows before it over its length."""
    matrix = np.random.default_rng(3).normal(size=(3, 5))
    stretched = np.diag([1e-6, 1.0, 1e6]) @ matrix
    ours, same = (evaluated(lambda a: [OrthogonalFactor.of(a).sines], m)[0].ravel() for m in (matrix, stretched))
    expected = []
    for row in range(3):
        span, direction = matrix[:row].T, matrix[row]
        left = direction - span @ np.linalg.lstsq(span, direction, rcond=None)[0] if row else direction
        expected.append(np.linalg.norm(left) / np.linalg.norm(direction))
    np.testing.assert_allclose(ours, expected, rtol=1e-12)
    np.testing.assert_allclose(same, expected, rtol=1e-9)
