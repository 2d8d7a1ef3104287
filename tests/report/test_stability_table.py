"""The stability table: which rows, with which numbers."""

from __future__ import annotations

from amble.analysis import monitors
from amble.report.stability_results import perturbed_results
from amble.report.stability_table import stability_table
from amble.types import Json
from tests.synthetic import amble_pattern, synthetic_gait, synthetic_trace

RADIUS = {"initial": 2.3219, "stabilized": 0.36727, "error": 1.8866e-5}


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
