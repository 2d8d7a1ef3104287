from __future__ import annotations

import numpy as np
import pytest

from amble.errors import InputError
from amble.simulation import simulate
from amble.stability import contraction, fixed_point, multipliers, section_distances
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
