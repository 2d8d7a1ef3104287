"""Samples of gaits and traces: unfolding, continuity, lookup."""

import dataclasses

import numpy as np
import pytest

from amble.analysis.samples import samples_of_gait, samples_of_trace
from amble.errors import InputError, UnknownNameError
from tests.synthetic import PERIOD, SPEED, amble_pattern, forces, motion, synthetic_gait, synthetic_trace, torques


def test_unfolded_half_is_the_second_half_of_the_motion() -> None:
    """The synthetic motion is known for all times; the gait holds its first half only."""
    found = samples_of_gait(synthetic_gait(), cycles=2)
    positions, velocities = motion(found.times)
    positions[:, :2] -= positions[0, :2]
    # y is laid out from the mirrored start, which for this motion is where it was before
    assert np.allclose(found.positions - [*found.positions[0, :2], *np.zeros(16)], positions, atol=1e-12)
    assert np.allclose(found.velocities, velocities, atol=1e-12)
    assert np.allclose(found.torques, torques(found.times), atol=1e-12)
    assert found.distance == pytest.approx(2.0 * PERIOD * SPEED, rel=1e-12)
    for stance in range(4):
        inside = found.stances == stance
        assert np.allclose(found.forces[inside], forces(found.times[inside], stance), atol=1e-12)
    assert found.cycles.tolist() == [0.0] * 124 + [1.0] * 124
    assert found.segments[-1] == 7.0


def test_gait_and_trace_of_one_motion_agree() -> None:
    gait = samples_of_gait(synthetic_gait(31), cycles=2)
    trace = samples_of_trace(synthetic_trace(2, 31), amble_pattern())
    for name in ("times", "segments", "stances", "cycles", "positions", "velocities", "torques", "forces"):
        assert np.allclose(getattr(gait, name), getattr(trace, name), atol=1e-12), name


def test_only_some_cycles() -> None:
    whole = samples_of_trace(synthetic_trace(3), amble_pattern())
    last = whole.only(2, 3)
    assert last.distance == pytest.approx(SPEED * PERIOD)
    assert last.times[0] == pytest.approx(2.0 * PERIOD)
    assert set(last.cycles) == {2}
    with pytest.raises(InputError, match="cycles 3 to 4"):
        whole.only(3, 5)


def test_motion_for_metrics() -> None:
    found = samples_of_gait(synthetic_gait())
    made = found.motion({"pinv": found.torques})
    assert made.joints == found.robot.joint_names
    assert made.speed == pytest.approx(SPEED)
    assert made.duration == pytest.approx(PERIOD)
    assert made.mass == pytest.approx(21.5)
    assert np.array_equal(made.speeds[:, 4], found.coordinate(found.robot.joint_names[4])[1])


def test_what_does_not_fit_is_refused() -> None:
    trace = synthetic_trace()
    with pytest.raises(UnknownNameError, match="unknown signal 'force'; known: torque"):
        samples_of_trace(dataclasses.replace(trace, signals={"torque": trace.signals["torque"]}), amble_pattern())
    with pytest.raises(InputError, match="30 states"):
        samples_of_trace(dataclasses.replace(trace, state=trace.state[:, :30]), amble_pattern())
    with pytest.raises(InputError, match="from 1 to"):
        samples_of_gait(synthetic_gait(), cycles=0)


@pytest.mark.parametrize("what", ["torque", "force", "state"])
@pytest.mark.parametrize("value", [1e300, -1e13, np.nan, np.inf])
def test_a_trace_of_numbers_that_no_robot_has_is_refused(what: str, value: float) -> None:
    """Squares of torques of 1e300 are infinite: a report of such a trace ended in a spline of SciPy."""
    trace = synthetic_trace(1, 31)
    values = np.array(trace.state if what == "state" else trace.signals[what])
    values[3, 0] = value
    changed = {"state": values} if what == "state" else {"signals": {**trace.signals, what: values}}
    with pytest.raises(InputError, match=f"the trace has a {what} that is not finite or above"):
        samples_of_trace(dataclasses.replace(trace, **changed), amble_pattern())
