"""Steering: commands that change by so much a step, and a walk that is the gait's own where all gaits are one."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.gait.schedule_tables import impedance_schedule
from amble.simulation import simulate
from amble.simulation.steering import Stepper, steer


@pytest.fixture(scope="module")
def stepper(stabilised_gait: Gait) -> Stepper:
    """One gait at two speeds: whatever is commanded, the law is the same."""
    gait = replace(stabilised_gait, control=Impedance())
    return Stepper(impedance_schedule({(0.2,): gait, (0.3,): gait}, ("speed",)))


def test_commands_move_by_so_much_a_step_and_the_walk_is_the_gaits_own(stepper: Stepper, stabilised_gait: Gait) -> None:
    """Integrators of 1e-9 over two cycles that contract; the pieces of the references are cut the same."""
    period = stabilised_gait.period
    found = steer(stepper, [(0.0, (0.2,)), (0.1 * period, (0.3,))], (0.03,), 1.9 * period, tolerance=1e-9)
    assert found.completed
    assert stepper.count == 2
    assert [step.command[0] for step in found.steps] == pytest.approx([0.2, 0.23, 0.26, 0.29])
    assert [step.asked[0] for step in found.steps] == [0.2, 0.3, 0.3, 0.3]
    own = simulate(stabilised_gait, cycles=2, tolerance=1e-9, samples=2, control=Impedance(), unilateral=True)
    walked = np.array([*(step.state for step in found.steps[::2]), found.state])
    np.testing.assert_allclose(walked, own.section[:, : walked.shape[1]], atol=1e-6)
    assert found.time == pytest.approx(own.time[-1], abs=1e-7)
    assert sum(step.irregular for step in found.steps) == 0


def test_a_walk_that_falls_says_so(stepper: Stepper) -> None:
    gait = stepper.schedule.gait
    start = stepper.schedule.starts[0].copy()
    start[gait.robot.size + 2] = -3.0  # the base comes down
    found = steer(stepper, [(0.0, (0.2,))], (0.1,), 1.0, start=start)
    assert not found.completed
    assert found.ended.startswith("after ")
    assert "\n" not in found.ended


@pytest.mark.parametrize(
    ("commands", "changes", "duration", "sentence"),
    [
        ([], (0.1,), 1.0, "commands"),
        ([(0.0, (0.4,))], (0.1,), 1.0, "outside the gaits"),
        ([(0.0, (float("nan"),))], (0.1,), 1.0, "outside the gaits"),
        ([(0.0, (0.2, 0.2))], (0.1,), 1.0, "2 numbers"),
        ([(0.5, (0.2,))], (0.1,), 1.0, "begin at 0"),
        ([(0.0, (0.2,)), (0.0, (0.3,))], (0.1,), 1.0, "grow"),
        ([(0.0, (0.2,)), (float("nan"), (0.3,))], (0.1,), 1.0, "grow"),
        ([(0.0, (0.2,))], (0.0,), 1.0, "largest change"),
        ([(0.0, (0.2,))], (float("inf"),), 1.0, "largest change"),
        ([(0.0, (0.2,))], (0.1, 0.1), 1.0, "largest change"),
        ([(0.0, (0.2,))], (0.1,), 0.0, "duration"),
        ([(0.0, (0.2,))], (0.1,), float("inf"), "duration"),
        ([(0.0, (0.2,))], (0.1,), 1e6, "duration"),
    ],
)
def test_bad_commands_are_one_sentence(
    stepper: Stepper,
    commands: list[tuple[float, tuple[float, ...]]],
    changes: tuple[float, ...],
    duration: float,
    sentence: str,
) -> None:
    with pytest.raises(InputError, match=sentence) as refused:
        steer(stepper, commands, changes, duration)
    assert "\n" not in str(refused.value)
