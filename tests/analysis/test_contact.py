"""Monitors against traces with one planted defect each."""

import dataclasses

import numpy as np
import pytest

from amble.analysis.bounds import ContactBounds
from amble.analysis.contact import ContactReport, contact_report
from amble.errors import InputError, UnknownNameError
from amble.hybrid import SIMULTANEOUS, gait_pattern
from amble.simulation import Trace
from tests.synthetic import STANCES, Stances, amble_pattern, astro, synthetic_gait, synthetic_trace

BOUNDS = ContactBounds.of_gait(synthetic_gait())
PATTERN = amble_pattern()
FEET = PATTERN.robot.foot_names
TROT: Stances = (("fl", "rr"), ("fr", "rl")) * 2


def report(trace: Trace) -> ContactReport:
    return contact_report(trace, PATTERN, BOUNDS)


def planted(trace: Trace, signal: str, domain: int, cycle: int, column: int, value: float) -> tuple[Trace, float]:
    """Change one entry of one signal at the eighth sample of a domain visit; return the trace and the time."""
    row = np.flatnonzero((trace.domain == domain) & (trace.cycle == cycle))[7]
    values = trace.signals[signal].copy()
    values[row, column] = value
    return dataclasses.replace(trace, signals={**trace.signals, signal: values}), float(trace.time[row])


def test_sound_motion() -> None:
    found = report(synthetic_trace())
    assert found.min_normal_force == 105.0
    assert found.max_friction == pytest.approx(0.2)
    assert (found.max_penetration, found.max_drift, found.max_slip, found.pulls) == (0.0, 0.0, 0.0, 0)
    assert (found.min_pivot, found.sound_from, found.samples) == (2.5, 0, 240)
    assert found.violations == ()
    # 4 stances of 2 standing feet with 3 rows and 2 swinging feet with 1, 4 landings, 12 joints with 2, the pivot
    assert len(found.rows) == 4 * (2 * 3 + 2) + 4 + 24 + 1


@pytest.mark.parametrize(
    ("signal", "domain", "foot", "axis", "value", "name", "number"),
    [
        ("force", 1, "fr", 2, -7.0, "D2 fr normal force", -7.0),
        ("force", 3, "rl", 1, 105.0, "D4 rl friction", 1.0),
        ("foot", 0, "rr", 2, -0.004, "D1 rr height", -0.004),
    ],
)
def test_planted_defects_are_named_with_time_and_cycle(
    signal: str, domain: int, foot: str, axis: int, value: float, name: str, number: float
) -> None:
    trace, when = planted(synthetic_trace(3), signal, domain, 1, 3 * FEET.index(foot) + axis, value)
    found = report(trace)
    worst = next(each for each in found.violations if each.name == name)
    assert worst.value == pytest.approx(number)
    assert (worst.time, worst.cycle) == (when, 1)
    assert f"at {when:.4f} s, cycle 1" in str(worst)
    # no friction holds a foot that pulls
    assert [each.value for each in found.violations if each is not worst] == [np.inf] * (value == -7.0)
    # a penetration is no contact failure of the feet that stand
    assert found.sound_from == (0 if signal == "foot" else 2)


@pytest.mark.parametrize("signal", ["force", "foot", "foot_velocity"])
def test_a_motion_without_bound_is_told_without_a_warning(signal: str) -> None:
    """Its squares are infinite; a friction that is no number would hold no foot."""
    trace = synthetic_trace()
    found = report(dataclasses.replace(trace, signals={**trace.signals, signal: 1e300 * trace.signals[signal]}))
    assert bool(found.violations) == (signal == "force")
    assert not np.isnan(found.max_friction)


def test_summary_numbers_and_cycles() -> None:
    trace, _ = planted(synthetic_trace(3), "force", 1, 1, 3 * FEET.index("fr") + 2, -7.0)
    found = report(trace)
    assert (found.min_normal_force, found.pulls) == (-7.0, 1)
    assert found.normal_forces.tolist() == [105.0, -7.0, 105.0]
    # no friction holds a foot that pulls
    assert found.frictions == pytest.approx([0.2, np.inf, 0.2])
    assert found.max_friction == np.inf
    sunk, _ = planted(synthetic_trace(2), "foot", 0, 1, 3 * FEET.index("rr") + 2, -0.004)
    assert report(sunk).max_penetration == 0.004
    assert report(sunk).penetrations.tolist() == [0.0, 0.004]


def test_last_cycle_unsound_is_sound_from_nowhere() -> None:
    trace, _ = planted(synthetic_trace(3), "force", 2, 2, 3 * FEET.index("fl") + 2, 0.0)
    assert report(trace).sound_from is None


def test_drift_is_counted_from_the_start_of_the_stance_phase() -> None:
    """rr stands through D2 and D3; a foot that slides 1 mm in each has drifted 2 mm, not more in later cycles."""
    trace = synthetic_trace(3)
    column = 3 * FEET.index("rr")
    standing = np.isin(trace.domain, (1, 2))
    foot = trace.signals["foot"].copy()
    foot[standing, column] += 1e-3 * (trace.clock / np.array([0.15, 0.05, 0.15, 0.05])[trace.domain])[standing]
    foot[trace.domain == 2, column] += 1e-3
    found = report(dataclasses.replace(trace, signals={**trace.signals, "foot": foot}))
    assert found.max_drift == pytest.approx(2e-3, rel=1e-9)
    assert found.drifts == pytest.approx([2e-3] * 3)
    assert [worst.name for worst in found.violations] == ["D3 rr drift"]


def test_stance_phase_across_the_cycle_boundary_is_one_phase() -> None:
    """rl lands in D4 and stands on through D1 of the next cycle: a shift between the two is drift."""
    trace = synthetic_trace(2)
    foot = trace.signals["foot"].copy()
    foot[(trace.domain == 0) & (trace.cycle == 1), 3 * FEET.index("rl") + 1] += 0.5
    found = report(dataclasses.replace(trace, signals={**trace.signals, "foot": foot}))
    assert found.drifts == pytest.approx([0.0, 0.5])


@pytest.mark.parametrize("gap", [0.008, -0.003, 2e-5, -5e-6])
@pytest.mark.parametrize("stances", [STANCES, TROT])
def test_a_foot_stopped_off_the_ground_is_named_with_its_distance(gap: float, stances: Stances) -> None:
    """Of the feet that land, whichever it is; the last of a pair was seen by no monitor."""
    pattern = gait_pattern(astro(), stances, landing_rule=SIMULTANEOUS)  # as in the synthetic trace
    trace = synthetic_trace(3, stances=stances)
    switch = pattern.all_switches[1]
    for foot in switch.landing:
        points = trace.signals["foot"].copy()
        end = np.flatnonzero((trace.domain == 1) & (trace.cycle == 2))[-1]
        points[end, 3 * FEET.index(foot) + 2] += gap
        found = contact_report(dataclasses.replace(trace, signals={**trace.signals, "foot": points}), pattern, BOUNDS)
        row = next(row for row in found.rows if row.name == f"{switch.name} height at touchdown {foot}")
        assert row.value == pytest.approx(gap, abs=1e-15)
        assert (row.passed, row.cycle) == (abs(gap) <= 1e-5, 2)
        assert found.max_landing_gap == pytest.approx(abs(gap))
        assert found.landing_gaps == pytest.approx([0.0, 0.0, abs(gap)])


def test_joint_limits_by_name() -> None:
    trace = synthetic_trace(2)
    torque = trace.signals["torque"].copy()
    torque[100, 5] = -61.0
    state = trace.state.copy()
    state[33, 18 + 6 + 2] = -4.5
    found = report(dataclasses.replace(trace, state=state, signals={**trace.signals, "torque": torque}))
    joints = PATTERN.robot.joint_names
    assert [(each.name, each.value) for each in found.violations] == [
        (f"{joints[5]} torque", 61.0),
        (f"{joints[2]} speed", 4.5),
    ]


def test_five_hundred_cycles_are_two_hundred_and_fifty_times_two() -> None:
    trace = synthetic_trace(2)
    repeated = {name: np.tile(values, (250, 1)) for name, values in trace.signals.items()}
    long = dataclasses.replace(
        trace,
        time=np.tile(trace.time, 250),
        clock=np.tile(trace.clock, 250),
        domain=np.tile(trace.domain, 250),
        cycle=np.repeat(np.arange(500), 120),
        state=np.tile(trace.state, (250, 1)),
        signals=repeated,
        cycles=500,
    )
    found = report(long)
    assert len(found.normal_forces) == 500
    # the same two cycles over and over: every cycle's worst is that of the short trace, and the total is its own
    short = report(trace)
    for name in ("normal_forces", "frictions", "penetrations"):
        np.testing.assert_array_equal(getattr(found, name), np.tile(getattr(short, name), 250))
    assert found.samples == 250 * short.samples
    assert [row.value for row in found.rows if row.kind != "drift"] == [
        row.value for row in short.rows if row.kind != "drift"
    ]


def test_the_smallest_pivot_is_the_smallest() -> None:
    """The synthetic trace has one pivot only, of which the largest is the smallest."""
    trace = synthetic_trace()
    pivots = np.linspace(0.5, 2.5, trace.time.size)[:, None]
    assert report(dataclasses.replace(trace, signals={**trace.signals, "pivot": pivots})).min_pivot == 0.5


def test_unusable_input() -> None:
    trace = synthetic_trace()
    with pytest.raises(UnknownNameError, match="unknown signal 'pivot'"):
        report(dataclasses.replace(trace, signals={k: v for k, v in trace.signals.items() if k != "pivot"}))
    with pytest.raises(InputError, match="bound on friction"):
        dataclasses.replace(BOUNDS, friction=-0.1)
    with pytest.raises(InputError, match="torque of 'fl_knee'"):
        dataclasses.replace(BOUNDS, torques={"fl_knee": float("nan")})
