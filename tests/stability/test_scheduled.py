"""Steps under a gain-scheduled law: the section's derivative by other ways, and changes of commands that are walked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.impedance import Impedance, unpacked
from amble.gait.schedule import Schedule
from amble.gait.schedule_tables import impedance_schedule
from amble.simulation.steering import Stepper, steer
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


@pytest.fixture(scope="module")
def unlike(schedule: Schedule) -> Schedule:
    """Of the second gait the feed-forward changed at random by some N m: an orbit of another posture."""
    tables, rng, joints = schedule.tables.copy(), np.random.default_rng(1), len(schedule.gait.robot.joints)
    for row in tables[1]:
        unpacked(row, joints)[4][1, :, :, 0] += rng.normal(scale=2.0, size=joints)
    return replace(schedule, tables=tables)


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
    assert found.schedule.leads == pytest.approx(0.0, abs=1e-2)  # N m for a change by 1 m/s: a miss of rounding alone
    radius = max(sample.radius for sample in found.samples)
    assert radius <= found.rate < 1.0
    for sample in found.samples:
        (matrix,) = sample.matrices
        decrease = found.rate**2 * found.metric - matrix.T @ found.metric @ matrix
        assert np.linalg.eigvalsh(0.5 * (decrease + decrease.T)).min() > -1e-9 * np.linalg.norm(found.metric)


def test_drawn_commands_within_the_bound_are_walked(unlike: Schedule) -> None:
    """Between unlike gaits a change over the whole range ends a walk; what commands may use is kept for 200 steps."""
    found = track(unlike)
    assert found.tried[0] < 0.1
    stepper, rng = Stepper(found.schedule), np.random.default_rng(8)
    commands = [(1.0 * second, (rng.uniform(0.2, 0.3),)) for second in range(30)]
    walked = steer(stepper, commands, found.changes, 30.0)
    assert walked.completed, walked.ended
    assert sum(step.irregular for step in walked.steps) == 0
    changed = np.abs(np.diff([step.command[0] for step in walked.steps]))
    assert changed.max() == pytest.approx(found.changes[0], rel=1e-12)


@pytest.mark.parametrize("between", [0, 101, 10**20])
def test_an_amount_of_samples_is_bounded(schedule: Schedule, between: int) -> None:
    with pytest.raises(InputError, match="samples between two gaits"):
        track(schedule, between)
