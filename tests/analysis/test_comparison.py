"""Comparisons: lookup, percentages, labels."""

from collections.abc import Callable

import pytest

from amble.analysis.comparison import Comparison, compare
from amble.analysis.energy import TorqueMetrics
from amble.analysis.motion import Motion
from amble.control.actuator import ACTUATORS, PAPER
from amble.errors import InputError, UnknownNameError

Builder = Callable[..., Motion]


def entry(law: str, cot: float, peak: float, rms: float) -> TorqueMetrics:
    """Metrics with the numbers a table prints."""
    return TorqueMetrics(
        motion="simulated",
        law=law,
        actuator="paper",
        cot=cot,
        cot_error=0.0,
        peak_torque=peak,
        peak_joint="fl_knee",
        peak_time=0.0,
        rms_torque=rms,
        mechanical_power=0.0,
        heat_power=0.0,
    )


def test_reductions_of_the_papers_table() -> None:
    """The paper's Table 1 gives 29.1, 20.7 and 17.9 percent."""
    table = Comparison((entry("drop", 6.389, 83.97, 9.659), entry("pinv", 4.532, 66.55, 7.932)))
    found = table.reduction("drop", "pinv", "simulated", "paper")
    assert found.cot == pytest.approx(29.1, abs=0.05)
    assert found.peak_torque == pytest.approx(20.7, abs=0.05)
    assert found.rms_torque == pytest.approx(17.9, abs=0.05)


def test_every_law_and_actuator_is_there_once(oscillating_motion: Builder) -> None:
    table = compare([oscillating_motion(9)], ACTUATORS.entries)
    keys = [(each.law, each.motion, each.actuator) for each in table.metrics]
    assert len(keys) == len(set(keys)) == 4
    # drop torques are 1.3 times pinv's in this motion
    assert table.reduction("drop", "pinv", "nominal", "paper").rms_torque == pytest.approx(100.0 * 0.3 / 1.3)
    assert table.reduction("pinv", "drop", "nominal", "datasheet").rms_torque == pytest.approx(-30.0)


def test_unknown_names_are_named(oscillating_motion: Builder) -> None:
    table = compare([oscillating_motion(9)], [PAPER])
    with pytest.raises(UnknownNameError, match="unknown actuator 'datasheet'; known: paper"):
        table.of("pinv", "nominal", "datasheet")
    with pytest.raises(UnknownNameError, match="unknown motion"):
        table.of("pinv", "simulated", "paper")
    with pytest.raises(UnknownNameError, match="unknown law"):
        table.of("qp", "nominal", "paper")


def test_two_motions_of_one_label_are_refused(oscillating_motion: Builder) -> None:
    with pytest.raises(InputError, match="same label"):
        compare([oscillating_motion(9), oscillating_motion(9)], [PAPER])
