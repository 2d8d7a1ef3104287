"""The largest norm of a power of the return map."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.stats import ortho_group

from amble.hybrid import HybridSystem
from amble.stability import Spectrum, fixed_point, multipliers
from amble.stability.growth import growth, in_units
from tests.hybrids import travelling


@pytest.mark.parametrize("seed", range(8))
def test_it_is_the_largest_over_many_powers(seed: int) -> None:
    draw = np.random.default_rng(seed)
    size = int(draw.integers(2, 9))
    matrix = draw.normal(size=(size, size))
    matrix = np.triu(draw.uniform(0, 20) * matrix, 1) + np.diag(draw.uniform(-0.97, 0.97, size))
    turn = ortho_group.rvs(size, random_state=seed)
    found = growth(turn @ matrix @ turn.T)
    norms = [np.linalg.norm(np.linalg.matrix_power(matrix, k), 2) for k in range(1, 1000)]
    assert found.factor == pytest.approx(max(norms))
    assert found.cycles == 1 + int(np.argmax(norms))


def test_what_only_shrinks_has_its_first_cycle_s_factor() -> None:
    assert growth(np.diag([0.5, 0.2])).factor == pytest.approx(0.5)
    assert growth(np.zeros((3, 3))).cycles == 1


def test_a_known_transient() -> None:
    """A = [[r, c], [0, r]]: A^k = [[r^k, k c r^(k-1)], [0, r^k]], largest near k = -1 / log r."""
    r, c = 0.95, 100.0
    found = growth(np.array([[r, c], [0.0, r]]))
    assert found.cycles == pytest.approx(-1 / np.log(r), abs=1)
    assert found.factor == pytest.approx(found.cycles * c * r ** (found.cycles - 1), rel=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_scaled_growth_is_that_of_the_scaled_system(seed: int) -> None:
    """Change the units of the states by hand, symmetries and all, and compare the norms of the powers."""
    draw = np.random.default_rng(seed)
    n, k = 7, int(draw.integers(0, 3))
    units = np.exp(draw.normal(size=n))
    along = draw.normal(size=(n, k))
    # a map that keeps the span of the generators
    whole = np.linalg.qr(np.column_stack([along, draw.normal(size=(n, n - k))]))[0]
    block = draw.normal(size=(n, n))
    block[k:, :k] = 0.0
    matrix = whole @ block @ whole.T

    def reduced(matrix: np.ndarray, along: np.ndarray) -> Spectrum:
        basis = np.linalg.qr(along, mode="complete")[0][:, k:] if k else np.eye(n)
        quotient = basis.T @ matrix @ basis
        return Spectrum(np.linalg.eigvals(quotient), 0.0, (), quotient, basis)

    scaled = reduced(matrix * units[np.newaxis, :] / units[:, np.newaxis], along / units[:, np.newaxis])
    found = in_units(reduced(matrix, along), units)
    for power in (1, 2, 5):
        expected = np.linalg.norm(np.linalg.matrix_power(scaled.matrix, power), 2)
        assert np.linalg.norm(np.linalg.matrix_power(found, power), 2) == pytest.approx(expected, rel=1e-9)


def test_multipliers_do_not_know_units() -> None:
    system: HybridSystem = travelling(0.7, -1)
    found = multipliers(system, fixed_point(system, np.array([0.0, 0.3, 1.0, -2.0, 0.4])).state)
    scaled = in_units(found, np.array([1.0, 0.1, 5.0, 5.0, 2.0]))
    np.testing.assert_allclose(
        np.sort(np.abs(np.linalg.eigvals(scaled))), np.sort(np.abs(found.multipliers)), atol=1e-8
    )
