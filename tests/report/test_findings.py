"""The tables of what a run found: the paper's numbers, contacts, stability."""

from __future__ import annotations

import numpy as np
import pytest

from amble.analysis import Comparison, ContactBounds, contact_report, monitors, samples_of_gait
from amble.control.actuator import ACTUATORS
from amble.errors import UnknownNameError
from amble.report import contact_rows, contact_summary, paper_table
from amble.report.findings import PAPER_REDUCTION, PAPER_ROWS, WHY_DIFFERENT, stability_table
from amble.report.stability_results import perturbed_results
from amble.types import Json
from tests.synthetic import amble_pattern, measured, synthetic_gait, synthetic_trace

RADIUS = {"initial": 2.3219, "stabilized": 0.36727, "error": 1.8866e-5}


@pytest.fixture(scope="module")
def comparison() -> Comparison:
    samples = samples_of_gait(synthetic_gait())
    return measured([samples.motion({"drop": 1.25 * samples.torques, "pinv": samples.torques})], ACTUATORS.entries)


def pulling(cycle: int, cycles: int = 4) -> Json:
    """What is said of a motion in which one foot pulls in one cycle."""
    trace = synthetic_trace(cycles)
    force = trace.signals["force"].copy()
    row = int(((trace.domain == 1) & (trace.cycle == cycle)).nonzero()[0][3])
    force[row, 3 * amble_pattern().robot.foot_names.index("fr") + 2] = -3.5
    trace.signals["force"] = force
    return perturbed_results(synthetic_gait(), trace, 1e-3, 0)


def test_every_number_has_its_row() -> None:
    table = stability_table(
        {
            "spectral_radius": RADIUS,
            "contraction": {"measured": 0.36, "predicted": 0.37, "relative_difference": 0.027},
            "section_error": 1.344e-9,
            "section_error_perturbed": 1.5e-9,
            "perturbed": pulling(1),
        }
    )
    rows = dict(table.rows)
    assert rows["spectral radius before stabilisation"] == "2.322"
    assert rows["spectral radius after stabilisation"] == "0.3673"
    assert rows["its error bar"] == "1.9e-05"
    assert rows["leading mode, contraction measured in simulation"] == "0.3600"
    assert rows["section error, start on the orbit"] == "1.3e-09"
    assert rows["perturbed start, change of every state"] == "0.0010"
    assert rows["perturbed start, contacts sound from cycle"] == "2"
    assert rows["perturbed start, smallest normal force before that (N)"] == "-3.500"
    assert "estimate" in table.notes[0]


def test_what_a_run_does_not_have_gives_no_rows() -> None:
    assert len(stability_table({"spectral_radius": RADIUS}).rows) == 3


def test_only_the_cycles_before_the_motion_is_sound_count() -> None:
    gait, trace = synthetic_gait(), synthetic_trace(4)
    report = monitors(gait, trace)
    assert report.sound_from == 0
    assert perturbed_results(gait, trace, 1e-3, 0)["before_sound"] is None
    first, last = pulling(0), pulling(3)
    assert first["before_sound"]["min_normal_force"] == -3.5
    assert first["before_sound"]["max_friction"] is None  # no friction holds a foot that pulls
    # the last cycle is not sound: then the worst is that of the whole motion
    assert last["sound_from_cycle"] is None
    assert last["before_sound"] == {"min_normal_force": -3.5, "max_friction": None}
    rows = dict(stability_table({"spectral_radius": RADIUS, "perturbed": last}).rows)
    assert rows["perturbed start, largest friction used before that"] == "inf"
    assert "-" in dict(stability_table({"spectral_radius": RADIUS, "perturbed": last}).rows).values()


def test_published_reductions_follow_from_the_published_rows() -> None:
    """The paper's own percentages, so that a mistyped constant shows."""
    for name in ("cot", "peak_torque", "rms_torque"):
        before, after = (getattr(PAPER_ROWS[law], name) for law in ("drop", "pinv"))
        assert 100.0 * (before - after) / before == pytest.approx(getattr(PAPER_REDUCTION, name), abs=0.05)


def test_paper_table_has_every_number_with_its_actuator(comparison: Comparison) -> None:
    table = paper_table(comparison, ["nominal"], ["paper", "datasheet"])
    rows = {(row[0][:5], row[1], row[2]): row[3:] for row in table.rows}
    assert len(rows) == len(table.rows) == 9
    assert rows["Ma et", "paper", "paper"] == ("6.389", "83.97", "9.659")
    assert rows["propo", "paper", "paper"] == ("4.532", "66.55", "7.932")
    assert rows["reduc", "paper", "paper"] == ("29.1", "20.7", "17.9")
    for actuator in ("paper", "datasheet"):
        entry = comparison.of("pinv", "nominal", actuator)
        assert float(rows["propo", "ours, nominal", actuator][0]) == pytest.approx(entry.cot, rel=1e-3)
        # all torques are a quarter larger
        assert rows["reduc", "ours, nominal", actuator][1:] == ("20.0", "20.0")
    assert table.notes == (WHY_DIFFERENT,)
    assert WHY_DIFFERENT.count(". ") == 0
    with pytest.raises(UnknownNameError, match="unknown motion"):
        paper_table(comparison, ["simulated"], ["paper"])


def test_contact_tables() -> None:
    trace = synthetic_trace(3)
    force = trace.signals["force"].copy()
    pattern = amble_pattern()
    row = int(np.flatnonzero((trace.domain == 1) & (trace.cycle == 1))[3])
    force[row, 3 * pattern.robot.foot_names.index("fr") + 2] = -3.5
    trace.signals["force"] = force
    report = contact_report(trace, pattern, ContactBounds.of_gait(synthetic_gait()))
    summary = contact_summary(report)
    assert summary.rows[0] == ("smallest normal force of a stance foot (N)", "-3.500")
    assert "from cycle 2 on" in summary.notes[0]
    violated = contact_rows(report, only_violations=True)
    assert [each[0] for each in violated.rows] == ["D2 fr friction", "D2 fr normal force"]  # no friction holds a pull
    assert violated.rows[0][1:5] == ("0", "inf", "0.6000", "inf")
    assert violated.rows[1][1:5] == ("0", "-3.500", "-", "3.500")
    assert violated.rows[1][6] == "1"
    assert len(contact_rows(report).rows) == len(report.rows)
