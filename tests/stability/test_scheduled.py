"""Steps under a gain-scheduled law: the section's derivative by other ways, and changes of commands that are walked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.impedance import Impedance
from amble.gait.schedule import Schedule
from amble.gait.schedule_tables import impedance_schedule
from amble.stability import poincare_map
from amble.stability.sampled_step import on_section, sampled_step, section_coordinates
from amble.stability.scheduled import track
from amble.stability.spectrum import multipliers

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def schedule(stabilised_gait: Gait) -> Schedule:
    """One gait at two speeds."""
    gait = replace(stabilised_gait, control=Impedance())
    return impedance_schedule({(0.2,): gait, (0.3,): gait}, ("speed",))


def test_the_derivative_on_the_section(schedule: Schedule) -> None:
    """Its eigenvalues are the multipliers modulo the symmetries; along random directions it is what differences say."""
    found = sampled_step(schedule, (0.25,))
    (matrix,) = found.matrices
    system = closed_loop(schedule.gait, control=schedule.law((0.25,)), half=True)
    along, kept = section_coordinates(schedule, system)
    assert np.abs(found.state[along]).max() <= 1e-12
    expected = np.sort(np.abs(multipliers(system, found.state).multipliers))
    np.testing.assert_allclose(np.sort(np.abs(np.linalg.eigvals(matrix)))[-8:], expected[-8:], atol=1e-6)
    rng, step = np.random.default_rng(3), 1e-6
    for _ in range(3):
        direction = np.zeros(found.state.size)
        direction[kept] = matrix @ rng.normal(size=kept.size)
        direction /= np.linalg.norm(direction)
        ends = [
            on_section(system, along, poincare_map(system, found.state + sign * step * direction)).image[kept]
            for sign in (1.0, -1.0)
        ]
        slope = (ends[0] - ends[1]) / (2.0 * step)
        np.testing.assert_allclose(slope, matrix @ direction[kept], atol=1e-4 * np.linalg.norm(slope))


def test_one_law_for_all_commands_takes_any_change(schedule: Schedule) -> None:
    """Where all gaits are one the largest change that is tried is walked, and the rate is that of the one orbit."""
    found = track(schedule)
    assert found.tried == pytest.approx((0.1,))
    assert found.changes == pytest.approx((0.1 / np.sqrt(2.0),))
    assert found.schedule.leads == pytest.approx(
        0.0, abs=0.2
    )  # N m for a change by 1 m/s: of gaits that differ some 20
    radius = max(sample.radius for sample in found.samples)
    assert radius <= found.rate < 1.0
    for sample in found.samples:
        (matrix,) = sample.matrices
        decrease = found.rate**2 * found.metric - matrix.T @ found.metric @ matrix
        assert np.linalg.eigvalsh(0.5 * (decrease + decrease.T)).min() > -1e-9 * np.linalg.norm(found.metric)


@pytest.mark.parametrize("between", [0, 101, 10**20])
def test_an_amount_of_samples_is_bounded(schedule: Schedule, between: int) -> None:
    with pytest.raises(InputError, match="samples between two gaits"):
        track(schedule, between)
