"""The example of an actuator: its heat is that of three windings, and laws, files and comparisons know it by name."""

from __future__ import annotations

import numpy as np
import pytest
from examples.extending.actuator_geared import GEARED, brushless

from amble.analysis import compare_laws, every_law
from amble.control import MinimumPower, PseudoInverse
from amble.control.actuator import ACTUATORS
from amble.control.allocation import LAWS
from amble.errors import InputError
from amble.gait import Gait


def test_heat_is_that_of_three_sinusoidal_currents() -> None:
    """Winding k carries I sin(a - 120 deg k) and induces K_e sin(a - 120 deg k) a rad/s."""
    kv, resistance, gear, torque = 100.0, 0.1, 9.0, 13.0
    angle = np.linspace(0.0, 2.0 * np.pi, 300, endpoint=False)
    shape = np.array([np.sin(angle - 2.0 * np.pi * k / 3.0) for k in range(3)])
    line = 60.0 / (2.0 * np.pi * kv)  # amplitude between two lines, V s/rad
    per_ampere = np.mean(np.sum(line / np.sqrt(3.0) * shape * shape, axis=0))  # torque that I = 1 A causes, N m
    amplitude = torque / gear / per_ampere
    heat = np.mean(np.sum(resistance * (amplitude * shape) ** 2, axis=0))
    model = brushless("any", kv=kv, phase_resistance=resistance, gear_ratio=gear, source="a test")
    assert float(model.heat(torque)) == pytest.approx(heat, rel=1e-12)


def test_laws_and_files_know_it_by_name() -> None:
    law = MinimumPower("geared")
    assert law == MinimumPower(GEARED)
    written = LAWS.encode(law, "file")
    assert written == {"name": "power", "parameters": {"actuator": "geared"}}
    assert LAWS.decode(written, "file") == law
    with pytest.raises(InputError, match="unknown actuator 'servo'; known: paper, datasheet, geared"):
        MinimumPower("servo")


def test_comparisons_count_with_it(walking_gait: Gait) -> None:
    assert "power (geared)" in every_law(walking_gait).laws
    table = compare_laws(walking_gait, [PseudoInverse()])
    assert {name for entry in table.metrics for name in entry.energy} == set(ACTUATORS.names)
