"""Reports of gaits that are not the paper's: any stance, flight, steps in place; none of them speaks of the paper."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.analysis import ContactBounds, compare_laws, contact_report, samples_of_gait, samples_of_trace
from amble.control import PseudoInverse, joint_outputs
from amble.control.actuator import ACTUATORS
from amble.gait import Gait
from amble.hybrid.gaits import GAITS
from amble.report import law_table
from amble.report.allocation import allocation_results
from amble.report.run import RunReport, main_table, run_results, write_run
from tests.synthetic import SPEED, amble_pattern, astro, forces, measured, synthetic_gait, synthetic_trace


def other(name: str) -> Gait:
    """The synthetic motion under the stances of another gait of two solved domains."""
    gait, pattern = synthetic_gait(), GAITS[name](astro(), amble_pattern().ground, amble_pattern().contact)
    pattern = replace(pattern, stances=pattern.stances[:2], mirrored=False)
    outputs = joint_outputs(pattern)
    domains = []
    for number, (domain, stance) in enumerate(zip(gait.domains, pattern.stances, strict=True)):
        columns = [astro().foot_names.index(foot) for foot in stance.feet]
        every = forces(domain.times, number, tuple(stance.feet for stance in pattern.stances) * 2)
        force = every.reshape(-1, 4, 3)[:, columns].reshape(len(domain.times), -1)
        landing = pattern.switches[number].landing
        impulse = np.zeros(3 * len(pattern.switches[number].target.feet) if landing else 0)
        coefficients = np.zeros((len(outputs.of(domain.name).coordinates), 5))
        domains.append(replace(domain, forces=force, impulse=impulse, coefficients=coefficients))
    law = PseudoInverse()
    return replace(gait, pattern=pattern, outputs=outputs, law=law, domains=tuple(domains), speed=SPEED)


@pytest.mark.parametrize("name", ["walk", "bound", "pronk", "running trot"])
def test_laws_are_compared_on_any_stance_without_the_paper(name: str) -> None:
    """Stances of three and four feet were refused, and flight ended in an IndexError."""
    gait = other(name)
    found = compare_laws(gait)
    assert {"pinv", "power (datasheet)"} <= set(found.laws)
    text = law_table(found, "nominal").markdown() + str(found)
    assert "paper" not in text.lower()
    samples = samples_of_gait(gait)
    for entry in found.metrics:
        assert entry.torques.rms_torque > 0.0
    assert found.of("pinv", "nominal", "datasheet").rms_torque <= np.sqrt(np.mean(samples.torques**2)) * 2.0


def _in_place(gait: Gait) -> Gait:
    """The same motion, less its way."""

    domains, began = [], 0.0
    for part in gait.domains:
        moved = np.array(part.positions)
        moved[:, 0] -= SPEED * (began + part.times)
        moved[:, 1] = 0.0  # its sway takes two of these cycles
        domains.append(replace(part, positions=moved))
        began += part.duration
    return replace(gait, domains=tuple(domains), speed=0.0)


def test_steps_in_place_have_a_specific_power_instead_of_a_cost_of_transport() -> None:
    """It was 1.8e30."""
    gait = _in_place(other("pronk"))
    found = compare_laws(gait, [PseudoInverse()])
    table = law_table(found, "nominal")
    assert [name for name in table.header if "power/weight" in name] == ["power/weight in m/s (datasheet)"]
    assert not any("CoT" in name for name in table.header)
    numbers = allocation_results(found)["pinv"]["nominal"]
    assert numbers["cot"] == {"datasheet": None}
    metrics = found.of("pinv", "nominal", "datasheet")
    weight = gait.robot.mass * gait.robot.gravity
    power = (metrics.mechanical_power + metrics.heat_power) / weight
    assert numbers["specific_power"]["datasheet"] == pytest.approx(power, rel=1e-12)


@pytest.mark.usefixtures("unrendered")
@pytest.mark.parametrize("name", ["slow walk", "walk", "bound", "pronk"])
def test_a_page_of_another_gait_does_not_speak_of_the_paper(name: str, tmp_path: Path) -> None:
    """The contact report is that of the synthetic amble's trace, whose numbers do not matter here."""
    trace, own = synthetic_trace(2), replace(synthetic_gait(), law=PseudoInverse())
    gait = other(name) if name in GAITS else replace(own, pattern=replace(own.pattern, name=name))
    again = replace(samples_of_gait(gait, 2), label="simulated")
    simulated = again if name in GAITS else samples_of_trace(trace, gait.pattern)
    motions = [
        samples.motion({"drop": 1.25 * samples.torques, "pinv": samples.torques})
        for samples in (samples_of_gait(gait), simulated)
    ]
    run = RunReport(
        gait=gait,
        simulated=simulated,
        cycles=2,
        two_cycles=motions[1],
        comparison=measured(motions, ACTUATORS.entries),
        contact=contact_report(trace, own.pattern, ContactBounds.of_gait(own)),
        speed_achieved=SPEED,
        settings={},
        seconds={},
        versions={},
    )
    assert "Allocation laws" in main_table(run).title
    write_run(tmp_path, run)
    for file in ("report.md", "report.html", "results.json"):
        text = (tmp_path / file).read_text().lower().replace("--paper", "")  # a colour of the page
        assert "paper" not in text  # costs were those of its actuator model
    assert name in (tmp_path / "report.md").read_text().lower()
    assert json.loads(json.dumps(run_results(run)))["reduction_datasheet"]["rms_torque"] == pytest.approx(20.0)
