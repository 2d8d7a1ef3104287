"""A whole run in a folder: every file, every key, every figure on the page."""

import dataclasses
import json
import re
from pathlib import Path

import numpy as np
import pytest

from amble.analysis import ContactBounds, contact_report, samples_of_gait, samples_of_trace
from amble.control import PseudoInverse
from amble.control.actuator import ACTUATORS
from amble.report.run import RunReport, Stability, main_table, run_results, write_run
from tests.synthetic import SPEED, amble_pattern, measured, synthetic_gait, synthetic_trace


@pytest.fixture(scope="module")
def run() -> RunReport:
    gait = dataclasses.replace(synthetic_gait(), law=PseudoInverse())
    trace = synthetic_trace(3)
    simulated = samples_of_trace(trace, amble_pattern())
    two = samples_of_gait(gait, cycles=2)
    motions = [
        samples.motion({"drop": 1.25 * samples.torques, "pinv": samples.torques})
        for samples in (samples_of_gait(gait), simulated.only(2, 3))
    ]
    stability = Stability(
        before=np.array([17.0 + 0j, 0.1j, -0.1j]),
        after=np.array([0.44 + 0j]),
        radius=0.44,
        distances=1e-3 * 0.44 ** np.arange(4),
        results={"spectral_radius": {"initial": 17.0, "stabilized": 0.44, "error": 1e-6}},
    )
    return RunReport(
        gait=gait,
        simulated=simulated,
        cycles=3,
        two_cycles=two.motion({"drop": 1.25 * two.torques, "pinv": two.torques}),
        comparison=measured(motions, ACTUATORS.entries),
        contact=contact_report(trace, amble_pattern(), ContactBounds.of_gait(synthetic_gait())),
        speed_achieved=SPEED,
        settings={"tolerance": "1e-8"},
        seconds={"synthesis": 5.6},
        versions={"amble": "0.1.0", "C compiler": "cc 1.2"},
        stability=stability,
    )


def test_results_have_the_keys_that_readers_expect(run: RunReport) -> None:
    found = run_results(run)
    assert {"robot", "speed_desired", "speed_achieved", "cycles", "versions"} <= set(found)
    for methods in ("methods", "methods_datasheet"):
        for law in ("drop", "pinv"):
            for motion in ("nominal", "simulated"):
                assert {"cot", "peak_torque", "rms_torque"} <= set(found[methods][law][motion])
    assert found["methods"]["pinv"]["nominal"]["cot"] > found["methods_datasheet"]["pinv"]["nominal"]["cot"]
    assert found["reduction"]["rms_torque"] == pytest.approx(20.0)
    assert {"cot", "rms_torque", "peak_torque"} <= set(found["reduction"])
    assert {"min_normal_force", "max_friction", "max_penetration"} <= set(found["contact"])
    assert {"status", "iterations", "seconds", "variables", "constraints"} <= set(found["solver"])
    assert found["spectral_radius"]["stabilized"] == 0.44
    assert found["versions"] == {"amble": "0.1.0", "C compiler": "cc 1.2"}
    assert found["settings"] == {"tolerance": "1e-8"}
    assert found["seconds"] == {"synthesis": 5.6}
    # one motion, sampled twice over: nominal and simulated agree to the accuracy of the integrals
    nominal, simulated = (found["methods"]["drop"][motion]["cot"] for motion in ("nominal", "simulated"))
    assert simulated == pytest.approx(nominal, rel=1e-5)


@pytest.mark.usefixtures("unrendered")
def test_written_run_is_whole(run: RunReport, tmp_path: Path) -> None:
    written = write_run(tmp_path / "astro-amble", run)
    assert all(path.stat().st_size > 0 for path in written)
    place = tmp_path / "astro-amble"
    assert json.loads((place / "results.json").read_text()) == json.loads(json.dumps(run_results(run)))
    page = (place / "report.md").read_text(encoding="utf-8")
    stems = {path.stem for path in (place / "figures").iterdir()}
    assert stems == {
        "base_portraits",
        "joint_portraits",
        "footfall",
        "torques",
        "torque_speed",
        "joint_power",
        "foot_paths",
        "contact_forces",
        "cycle_portraits",
        "multipliers",
        "section_distance",
    }
    for stem in stems:
        assert f"(figures/{stem}.png)" in page
        assert f"(figures/{stem}.pdf)" in page
    shown = (place / "report.html").read_text(encoding="utf-8")
    assert shown.count("<figure") == len(stems)
    assert "20.0 % less RMS torque" in shown
    for table in (main_table(run),):
        assert table.markdown().strip() in page
    assert "20.0 % less RMS torque" in page
    assert re.search(r"spectral radius after stabilisation +\| +0\.4400 \|", page)
    assert "| tolerance" in page


def test_run_without_stability(run: RunReport) -> None:
    found = run_results(dataclasses.replace(run, stability=None, extra={"section_error": 1e-9}))
    assert "spectral_radius" not in found
    assert found["section_error"] == 1e-9
