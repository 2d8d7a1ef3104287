"""The task that crocoddyl is given, and what is told of its answer; crocoddyl itself is not in this environment."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from amble.gait import Gait
from benchmarks import shooting

ANSWER = {
    "solved": True,
    "iterations": 7,
    "nodes": 71,
    "build_s": 0.1,
    "solve_s": 2.0,
    "peak_torque": 30.0,
    "end_error": 0.01,
    "least_normal": 5.0,
    "most_friction": 0.5,
}


def test_the_task_ends_where_the_next_cycle_begins(stabilised_gait: Gait) -> None:
    """A row every 5 ms over one cycle and one beyond; both halves of the amble, four landings."""
    task = shooting.task(stabilised_gait)
    rows = len(task["qpos"])
    assert (rows - 1) / task["rate"] == pytest.approx(stabilised_gait.period, abs=1.0 / task["rate"])
    flags = np.array(task["contacts"])
    assert np.sum(np.diff(flags.astype(int), axis=0) == 1) == 4
    assert task["feet"] == [foot.frame for foot in stabilised_gait.robot.feet]
    assert task["qpos"][-1][0] - task["qpos"][0][0] == pytest.approx(
        stabilised_gait.speed * stabilised_gait.period, abs=0.01
    )


def test_figures_tell_the_answer(
    stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found = {figure.name: figure for figure in shooting.figures(ANSWER, stabilised_gait)}
    assert found["crocoddyl, solve from the first posture"].note == "7 iterations, solved"
    assert found["crocoddyl, peak torque"].value == 30.0
    monkeypatch.setattr(shooting, "PYTHON", tmp_path / "none")
    assert shooting.measure() == []
    assert "no crocoddyl" in capsys.readouterr().out
