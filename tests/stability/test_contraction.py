"""The leading multiplier measured in simulation."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import simulate
from amble.stability import contraction, fixed_point, multipliers, section_distances
from amble.stability.contraction import leading_mode, leading_subspace
from amble.stability.spectrum import Spectrum
from tests.hybrids import travelling


@pytest.mark.parametrize("rate", [0.3, 0.7, 0.95])
def test_a_known_rate_is_found_above_the_floor(rate: float) -> None:
    cycles = np.arange(60)
    distances = 0.1 * rate**cycles + 0.3 * (0.3 * rate) ** cycles + 1e-10
    found = contraction(distances, floor=1e-7)
    assert found.rate == pytest.approx(rate, rel=0.02)
    assert distances[found.last] > 1e-7


def test_scatter_gives_the_error() -> None:
    rng = np.random.default_rng(5)
    noise = 0.1
    rates = []
    for _ in range(200):
        distances = 0.8 ** np.arange(40) * np.exp(noise * rng.normal(size=40))
        rates.append(contraction(distances, floor=1e-9))
    spread = np.std([found.rate for found in rates])
    assert np.mean([found.error for found in rates]) == pytest.approx(spread, rel=0.2)  # 200 draws


def test_too_few_cycles_are_refused() -> None:
    with pytest.raises(InputError, match="needs 4 cycles above 1e-08; there are 2"):
        contraction(np.array([1e-2, 1e-4, 1e-6, 1e-9, 1e-12]))


@pytest.mark.parametrize("mirror", [1, -1])
def test_distances_do_not_see_the_symmetries(mirror: int) -> None:
    system = travelling(0.3, mirror)
    orbit = fixed_point(system, np.array([0.0, 0.3, 0.0, 0.0, 0.0]))
    trace = simulate(system, orbit.state + np.array([0.0, 0.01, 0.0, 0.0, 0.0]), 12, 1e-12)
    distances = section_distances(system, trace.section, orbit.state)
    assert distances[0] == pytest.approx(0.01)
    found = contraction(distances, floor=1e-10)
    assert found.rate == pytest.approx(multipliers(system, orbit.state).radius, rel=1e-3)


def decaying(rate: float) -> HybridSystem:
    """A second of standing still, then a share of the deviation: multipliers rate and 0."""
    x = ca.SX.sym("x", 2)
    domain = Domain.from_expressions("stay", x, ca.vertcat(1, 0))
    return HybridSystem(
        [domain], [Transition.from_expressions("stay", "stay", x, x[0] - 1, ca.vertcat(0, rate * x[1]), +1)]
    )


@pytest.mark.parametrize(("rate", "cycles"), [(1.5, 3), (0.9, 3), (-0.3, 3), (0.02, 2), (1e-3, 1)])
def test_a_known_rate_is_measured_while_it_is_to_be_seen(rate: float, cycles: int) -> None:
    system, state = decaying(rate), np.zeros(2)
    found = leading_mode(system, state, multipliers(system, state))
    assert found is not None
    assert found.cycles == cycles
    # linear, so that only the integrator's 1e-12 on what is left, at least 1e-9, remains
    assert found.rate == pytest.approx(abs(rate), rel=1e-3)
    assert found.difference < 1e-3


@pytest.mark.parametrize("rate", [1e-5, 0.0])
def test_what_one_cycle_forgets_is_not_measured(rate: float) -> None:
    system, state = decaying(rate), np.zeros(2)
    assert leading_mode(system, state, multipliers(system, state)) is None


def jordan(values: np.ndarray, coupling: float, bend: float) -> HybridSystem:
    """A second of standing still, then an upper triangular map with these multipliers, and a quadratic term."""
    size = len(values)
    x = ca.SX.sym("x", 1 + size)
    matrix = np.diag(values) + np.diag(np.full(size - 1, coupling), 1)
    after = ca.DM(matrix) @ x[1:] + bend * x[1:] ** 2
    domain = Domain.from_expressions("stay", x, ca.vertcat(1, ca.SX.zeros(size)))
    return HybridSystem([domain], [Transition.from_expressions("stay", "stay", x, x[0] - 1, ca.vertcat(0, after), +1)])


@pytest.mark.parametrize("seed", range(6))
def test_multipliers_that_nearly_meet_are_measured_together(seed: int) -> None:
    """A single mode of such a cluster has a condition up to 1e8: what a simulation shows of it alone is anything."""
    draw = np.random.default_rng(seed)
    count = int(draw.integers(2, 5))
    cluster = draw.uniform(0.3, 0.8) * (1.0 + draw.uniform(-1e-3, 1e-3, count))
    values = np.concatenate([cluster, cluster.min() * draw.uniform(-0.5, 0.5, 2)])
    system = jordan(values, float(draw.uniform(0.5, 1.0)), float(draw.uniform(1.0, 10.0)))
    state = np.zeros(1 + len(values))
    found = leading_mode(system, state, multipliers(system, state))
    assert found is not None
    assert found.modes == count
    assert found.predicted == pytest.approx(np.exp(np.mean(np.log(cluster))), rel=1e-9)
    assert found.difference < 1e-4  # of the start's square, 1e-10 times the condition of the whole cluster, is left


@pytest.mark.parametrize("seed", range(4))
def test_a_leading_subspace_is_invariant_and_its_coordinates_are_its_own(seed: int) -> None:
    draw = np.random.default_rng(seed)
    matrix = draw.normal(size=(9, 9))
    spectrum = Spectrum(multipliers=np.linalg.eigvals(matrix), radius=1.0, neutral=(), matrix=matrix, basis=np.eye(9))
    right, left, block = leading_subspace(spectrum)
    np.testing.assert_allclose(matrix @ right, right @ block, atol=1e-12)
    np.testing.assert_allclose(left.T @ matrix, block @ left.T, atol=1e-11)
    np.testing.assert_allclose(left.T @ right, np.eye(len(block)), atol=1e-12)
    largest = np.abs(np.linalg.eigvals(matrix)).max()
    assert np.abs(np.linalg.eigvals(block)).max() == pytest.approx(largest)


def test_a_spiral_is_measured_as_a_pair() -> None:
    """A complex pair turns as it shrinks: one coordinate of it alone is not monotone."""
    angle, rate = 1.1, 0.6
    x = ca.SX.sym("x", 3)
    turn = rate * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    domain = Domain.from_expressions("stay", x, ca.vertcat(1, 0, 0))
    after = ca.vertcat(0, ca.DM(turn) @ x[1:])
    system = HybridSystem([domain], [Transition.from_expressions("stay", "stay", x, x[0] - 1, after, +1)])
    found = leading_mode(system, np.zeros(3), multipliers(system, np.zeros(3)))
    assert found is not None
    assert (found.modes, found.predicted) == (2, pytest.approx(rate))
    assert found.difference < 1e-6
