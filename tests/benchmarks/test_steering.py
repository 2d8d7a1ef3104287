"""A steered walk beside the exported C: commands as the show asks for them, torques the same at every event."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.gait.schedule_tables import impedance_schedule
from amble.simulation.trace import COMPLETED
from amble.workflow.library import Transitions
from benchmarks.steering import Beside, drawn, walked


def test_every_second_command_is_half_a_range_away() -> None:
    schedule: Any = SimpleNamespace(values=((0.1, 0.2, 0.3), (-0.3, 0.3)))
    commands = drawn(schedule, 1000)
    assert commands.min(axis=0) == pytest.approx([0.1, -0.3], abs=0.01)
    assert commands.max(axis=0) == pytest.approx([0.3, 0.3], abs=0.01)
    far = np.any(np.abs(np.diff(commands, axis=0)) >= np.array([0.1, 0.3]), axis=1)
    assert far[::2].all()


@pytest.mark.slow
def test_c_and_python_walk_alike(stabilised_gait: Gait, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """One gait at two speeds, torques of changes drawn; a C controller that forgets a command is seen."""
    gait = replace(stabilised_gait, control=Impedance())
    schedule = impedance_schedule({(0.2,): gait, (0.3,): gait}, ("speed",))
    leads = np.random.default_rng(2).normal(size=(2, 1, 2, 12))
    found = Transitions(schedule=replace(schedule, leads=leads), changes=(0.02,))
    ended, told = walked(found, np.array([[0.2], [0.3], [0.22]]), tmp_path)
    assert ended == COMPLETED
    assert float(told.split("differ by ")[1].split()[0]) <= 1e-12
    monkeypatch.setattr(Beside, "enter", _at_the_lowest)
    (tmp_path / "other").mkdir()
    changed = replace(found, schedule=replace(schedule, leads=100.0 * leads))
    _, told = walked(replace(changed, changes=(0.001,)), np.array([[0.3], [0.2]]), tmp_path / "other")
    assert float(told.split("differ by ")[1].split()[0]) > 1e-6


def _at_the_lowest(beside: Beside, command: object) -> None:
    del command
    beside.library.amble_enter(beside.memory, 0)
