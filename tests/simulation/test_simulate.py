from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from amble.control.motion_equations import SMALLEST_PIVOT
from amble.errors import InputError, WorkError
from amble.gait import Gait
from amble.gait.closed_loop import start_state
from amble.progress import ProgressReport
from amble.simulation import simulate
from amble.simulation.simulate import perturbed
from amble.types import frozen
from tests.hybrids import GRAVITY, bouncing_ball, clockwork, two_phases

STATE = np.linspace(-1.0, 1.0, 36)


def test_a_ball_bounces_as_it_must() -> None:
    trace = simulate(bouncing_ball(0.8), np.array([0.0, 2.0]), 10, samples=7)
    assert trace.completed
    assert trace.cycles == 10
    flights = 2 * 2.0 / GRAVITY * 0.8 ** np.arange(10)
    assert np.array([event.time for event in trace.events]) == pytest.approx(np.cumsum(flights), abs=1e-12)
    assert trace.section == pytest.approx(np.column_stack([np.zeros(11), 2.0 * 0.8 ** np.arange(11)]), abs=1e-12)


def test_samples_are_even_and_events_have_one_on_both_sides() -> None:
    trace = simulate(bouncing_ball(0.5), np.array([0.0, 2.0]), 3, samples=5)
    assert trace.state.shape == (15, 2)
    for number, event in enumerate(trace.events):
        rows = np.flatnonzero(trace.cycle == number)
        assert np.diff(trace.clock[rows]) == pytest.approx(trace.clock[rows[-1]] / 4)
        assert trace.time[rows[-1]] == event.time
        assert np.array_equal(trace.state[rows[-1]], event.before)
        if number < 2:
            assert trace.time[rows[-1] + 1] == event.time
            assert np.array_equal(trace.state[rows[-1] + 1], event.after)


def test_energy_is_constant_in_flight_and_signals_keep_their_width() -> None:
    trace = simulate(bouncing_ball(0.8), np.array([0.0, 2.0]), 3)
    for cycle in range(3):
        energy = trace.signals["energy"][trace.cycle == cycle, 0]
        assert energy == pytest.approx(energy[0], rel=1e-13)
    assert trace.signals["pair"] == pytest.approx(2 * trace.state)


def test_a_domain_without_a_signal_records_nan() -> None:
    system = two_phases()
    quiet = simulate(system, np.array([0.0, 1.0, 0.2]), 2)
    assert not quiet.signals
    assert set(quiet.domain) == {0, 1}
    assert [event.transition for event in quiet.events] == ["push->pull", "pull->push"] * 2


@pytest.mark.parametrize(
    ("start", "time_limit", "reason"),
    [
        ((0.0, 1.0), 10.0, "the motion fell in domain 'flight' of cycle 1 at"),
        ((0.0, 0.1), 10.0, "the motion fell in domain 'flight' of cycle 0 at 0 s"),
        ((0.0, 1.0), 0.1, "the motion reached no guard within the time limit in domain 'flight' of cycle 0"),
    ],
)
def test_an_early_end_is_a_sentence(start: tuple[float, float], time_limit: float, reason: str) -> None:
    trace = simulate(bouncing_ball(0.5, floor=0.6), np.array(start), 10, time_limit=time_limit)
    assert not trace.completed
    assert trace.ended.startswith(reason)
    assert trace.cycles == len(trace.events) < 10
    assert trace.time.size == trace.state.shape[0] == trace.signals["energy"].shape[0] > 0
    assert trace.section.shape == (trace.cycles + 1, 2)


def test_a_graph_may_branch() -> None:
    trace = simulate(clockwork(("sine", -1, 0.0), ("line", +1, 0.0)), np.array([0.0]), 1, time_limit=200.0)
    assert [event.transition for event in trace.events] == ["first->line1", "line1->first"]


def test_progress_is_reported_every_cycle() -> None:
    calls: list[ProgressReport] = []
    simulate(bouncing_ball(), np.array([0.0, 1.0]), 3, progress=calls.append)
    assert [(call.done, call.of) for call in calls] == [(1, 3), (2, 3), (3, 3)]
    assert str(calls[0]) == "cycle 1 of 3"


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"start": [0.0, 1.0, 2.0]}, "has 3 values, not 2"),
        ({"start": [0.0, np.nan]}, "not finite"),
        ({"cycles": 0}, "0 cycles were asked for"),
        ({"tolerance": 1e-15}, "not between"),
        ({"tolerance": np.nan}, "not between"),
        ({"samples": 1}, "1 samples a domain were asked for"),
        ({"time_limit": 0.0}, "positive time"),
        ({"time_limit": np.inf}, "positive time"),
    ],
)
def test_bad_input_is_refused_in_one_sentence(change: Mapping[str, Any], sentence: str) -> None:
    arguments: dict[str, Any] = {"start": [0.0, 1.0], "cycles": 1, **change}
    arguments["start"] = np.array(arguments["start"])
    with pytest.raises(InputError, match=sentence):
        simulate(bouncing_ball(), **arguments)


def test_the_record_is_read_only() -> None:
    trace = simulate(bouncing_ball(), np.array([0.0, 1.0]), 1)
    with pytest.raises(ValueError, match="read-only"):
        trace.state[0, 0] = 1.0


def nearly_singular(gait: Gait, foot: str) -> Gait:
    """The gait with all joints but a swing knee, which no torque frees, as the outputs of D1, and 1e-7 of others."""
    names, robot = gait.robot.joint_names, gait.robot
    joints = np.eye(robot.size - 3)[3:][[j for j, name in enumerate(names) if name != f"{foot}_knee"]]
    assert gait.feedback is not None
    other = joints + 1e-7 * np.random.default_rng(0).normal(size=joints.shape)
    return replace(gait, feedback=replace(gait.feedback, weights={**gait.feedback.weights, "D1": frozen(other)}))


def test_a_motion_that_goes_on_without_rank_is_refused(stabilised_gait: Gait) -> None:
    """On its orbit the outputs vanish, so that the motion goes on; its torques mean nothing. Pivots of 5e-7."""
    assert simulate(stabilised_gait, cycles=1).signals["pivot"].min() > 1e3 * SMALLEST_PIVOT
    with pytest.raises(
        WorkError, match=r"lose rank in domain 'D[13]' at .* smallest pivot 5\.\de-07, at least 1e-06 is"
    ):
        simulate(nearly_singular(stabilised_gait, "fl"), cycles=1)


def test_a_motion_that_ends_is_a_trace_whatever_its_pivots(stabilised_gait: Gait) -> None:
    trace = simulate(nearly_singular(stabilised_gait, "rr"), cycles=1)
    assert not trace.completed
    assert trace.ended.startswith("the motion")
    assert trace.signals["pivot"].min() < SMALLEST_PIVOT


def test_a_gait_walks_from_another_start_too(stabilised_gait: Gait) -> None:
    start = perturbed(start_state(stabilised_gait), 1e-3, 4)
    trace = simulate(stabilised_gait, start, cycles=1)
    assert np.array_equal(trace.state[0], start)
    again = simulate(stabilised_gait, cycles=1, perturbation=1e-3, seed=4)
    assert np.array_equal(again.state, trace.state)


def test_what_only_a_gait_has_is_refused_of_a_system(stabilised_gait: Gait) -> None:
    ball: Any = bouncing_ball()
    with pytest.raises(InputError, match="is simulated from a start"):
        simulate(ball, cycles=1)
    with pytest.raises(InputError, match="only a gait takes another allocation law"):
        simulate(ball, np.array([0.0, 1.0]), 1, law=stabilised_gait.law)


@pytest.mark.parametrize("seed", range(3))
def test_every_state_moves_by_the_size_in_both_directions(seed: int) -> None:
    change = perturbed(STATE, 1e-3, seed) - STATE
    assert np.allclose(np.abs(change), 1e-3, rtol=1e-12)
    assert change.min() < 0.0 < change.max()


def test_the_seed_decides() -> None:
    assert np.array_equal(perturbed(STATE, 1e-3, 1), perturbed(STATE, 1e-3, 1))
    assert not np.array_equal(perturbed(STATE, 1e-3, 1), perturbed(STATE, 1e-3, 2))
    assert np.array_equal(perturbed(STATE, 0.0, 1), STATE)


@pytest.mark.parametrize("size", [-1e-3, math.nan, math.inf])
def test_a_size_that_makes_no_sense_is_refused(size: float) -> None:
    with pytest.raises(InputError, match="size of a perturbation"):
        perturbed(STATE, size, 0)


def test_a_negative_seed_is_refused() -> None:
    with pytest.raises(InputError, match="seed of a perturbation is a whole number from 0 on, not -1"):
        perturbed(STATE, 0.1, -1)
