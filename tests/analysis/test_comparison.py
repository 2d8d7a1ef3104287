"""Comparisons: lookup, percentages, labels."""

from collections.abc import Callable

import numpy as np
import pytest

from amble.analysis import compare_laws, reallocate, samples_of_gait
from amble.analysis.comparison import Comparison, LawMetrics, compare
from amble.analysis.energy import TorqueMetrics, torque_metrics
from amble.analysis.motion import Motion
from amble.control import PseudoInverse
from amble.control.actuator import ACTUATORS, PAPER
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from tests.synthetic import measured, synthetic_gait

Builder = Callable[..., Motion]


def entry(law: str, cot: float, peak: float, rms: float) -> LawMetrics:
    """Metrics with the numbers a table prints."""
    energy = TorqueMetrics(
        motion="simulated",
        law=law,
        actuator="paper",
        cot=cot,
        cot_error=0.0,
        specific_power=0.2 * cot,
        peak_torque=peak,
        peak_joint="fl_knee",
        peak_time=0.0,
        rms_torque=rms,
        mechanical_power=0.0,
        heat_power=0.0,
    )
    return LawMetrics(law=law, motion="simulated", energy={"paper": energy})


def test_reductions_of_the_papers_table() -> None:
    """The paper's Table 1 gives 29.1, 20.7 and 17.9 percent."""
    table = Comparison((entry("drop", 6.389, 83.97, 9.659), entry("pinv", 4.532, 66.55, 7.932)))
    found = table.reduction("drop", "pinv", "simulated", "paper")
    assert found.cot == pytest.approx(29.1, abs=0.05)
    assert found.peak_torque == pytest.approx(20.7, abs=0.05)
    assert found.rms_torque == pytest.approx(17.9, abs=0.05)


def test_every_law_and_actuator_is_there_once(oscillating_motion: Builder) -> None:
    table = measured([oscillating_motion(9)], ACTUATORS.entries)
    keys = [(each.law, each.motion, model) for each in table.metrics for model in each.energy]
    assert len(keys) == len(set(keys)) == 4
    # drop torques are 1.3 times pinv's in this motion
    assert table.reduction("drop", "pinv", "nominal", "paper").rms_torque == pytest.approx(100.0 * 0.3 / 1.3)
    assert table.reduction("pinv", "drop", "nominal", "datasheet").rms_torque == pytest.approx(-30.0)


def test_unknown_names_are_named(oscillating_motion: Builder) -> None:
    table = measured([oscillating_motion(9)], [PAPER])
    with pytest.raises(UnknownNameError, match="unknown actuator 'datasheet'; known: paper"):
        table.of("pinv", "nominal", "datasheet")
    with pytest.raises(UnknownNameError, match="unknown motion"):
        table.of("pinv", "simulated", "paper")
    with pytest.raises(UnknownNameError, match="unknown law"):
        table.of("qp", "nominal", "paper")


def test_two_motions_of_one_label_are_refused() -> None:
    motion = samples_of_gait(synthetic_gait())
    with pytest.raises(InputError, match="same label"):
        compare([motion, motion], {"pinv": PseudoInverse()}, [PAPER])


def test_no_law_is_an_error(stabilised_gait: Gait) -> None:
    """An empty choice meant every law, so this could not be reached from the command line's function."""
    with pytest.raises(InputError, match="no allocation law"):
        compare_laws(stabilised_gait, {})
    with pytest.raises(InputError, match="no allocation law"):
        compare_laws(stabilised_gait, [])


def test_a_record_holds_what_each_law_is_measured_by(stabilised_gait: Gait) -> None:
    """Energy is that of the law's own torques, and the limits are the gait's."""
    samples = samples_of_gait(stabilised_gait)
    law = PseudoInverse()
    (found,) = compare_laws(stabilised_gait, [law]).metrics
    motion = samples.motion({"pinv": reallocate(samples, [law])["pinv"].torques})
    for model in ACTUATORS.entries:
        assert found.energy[model.name] == torque_metrics(motion, "pinv", model)
    assert found.limits is not None
    own = stabilised_gait.limits.torques
    limits = [min(joint.effort, own[joint.name]) for joint in stabilised_gait.robot.joints]
    assert found.limits.peak_relative_torque == pytest.approx((np.abs(motion.torque("pinv")) / limits).max())
    assert found.torques.peak_torque == np.abs(motion.torque("pinv")).max()
