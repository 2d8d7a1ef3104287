"""A log against its gait: the gait's own motion, shifted and stretched, is found again; damaged logs are refused."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from amble.analysis.log_comparison import compare_log, read_log
from amble.analysis.samples import samples_of_gait
from amble.errors import InputError
from amble.gait import Gait
from tests.cli.run import exit_code
from tests.conftest import DATA


def written(gait: Gait, path: Path, pace: float, shift: float, offset: float, torque: bool = True) -> Path:
    """Write 1.3 s of the gait at another pace, from another phase, with one joint off by an angle."""
    cycle, joints = samples_of_gait(gait), gait.robot.joint_names
    times = np.arange(0.0, 1.3, 0.004)
    places = (times / (pace * gait.period) + shift) % 1.0
    shares = (cycle.times - cycle.times[0]) / gait.period
    angles = np.column_stack([np.interp(places, shares, column) for column in cycle.positions[:, 6:].T])
    angles[:, 3] += offset
    header = ["time", *joints, *(f"torque {joint}" for joint in joints if torque)]
    columns = (
        [100.0 + times[:, None], angles, np.full_like(angles, 3.0)] if torque else [100.0 + times[:, None], angles]
    )
    rows = [",".join(f"{value:.9g}" for value in row) for row in np.hstack(columns)]
    path.write_text("\n".join([",".join(header), *rows, ""]))
    return path


def test_pace_phase_and_error_are_found(stabilised_gait: Gait, tmp_path: Path) -> None:
    log = read_log(written(stabilised_gait, tmp_path / "log.csv", 1.07, 0.31, 0.0), stabilised_gait)
    found = compare_log(stabilised_gait, log)
    assert found.period == pytest.approx(1.07 * stabilised_gait.period, rel=1e-4)
    assert max(found.errors.values()) < 1e-4
    assert found.rms_torque == pytest.approx(3.0)
    assert found.planned_torque == pytest.approx(5.29, abs=0.05)


def test_a_joint_that_is_off_is_named(stabilised_gait: Gait, tmp_path: Path) -> None:
    """What is off by a constant moves pace and phase a little: to a tenth."""
    log = read_log(written(stabilised_gait, tmp_path / "log.csv", 1.0, 0.0, 0.05, torque=False), stabilised_gait)
    found = compare_log(stabilised_gait, log)
    assert max(found.errors, key=found.errors.__getitem__) == stabilised_gait.robot.joint_names[3]
    assert max(found.errors.values()) == pytest.approx(0.05, rel=0.1)
    assert found.rms_torque is None


@pytest.mark.parametrize(
    ("damage", "said"),
    [
        (lambda text: text.replace("time", "clock", 1), "0 columns 'time'"),
        (lambda text: text.replace("fl_knee", "knee", 1), "0 columns 'fl_knee'"),
        (lambda text: text.replace("100.004", "fast", 1), "line 3: 'fast' is not a number"),
        (lambda text: text.replace("100.004", "1e999", 1), "line 3 holds a number that is not finite"),
        (lambda text: text.replace("100.004", "99", 1), "their times ascending"),
        (lambda text: "\n".join(text.splitlines()[:5]), "needs 10 samples or more"),
        (lambda _: "", "0 columns 'time'"),
        (lambda text: "\n".join(text.splitlines()[:20]), "less than half a cycle"),
    ],
)
def test_a_damaged_log_is_refused(stabilised_gait: Gait, tmp_path: Path, damage: object, said: str) -> None:
    path = written(stabilised_gait, tmp_path / "log.csv", 1.0, 0.0, 0.0, torque=False)
    path.write_text(damage(path.read_text()))  # type: ignore[operator]
    with pytest.raises(InputError, match=said):
        compare_log(stabilised_gait, read_log(path, stabilised_gait))


def test_the_command_compares_a_log(stabilised_gait: Gait, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    log, out = str(written(stabilised_gait, tmp_path / "log.csv", 1.0, 0.0, 0.0)), tmp_path / "v.json"
    gait = str(DATA / "stabilised-amble.json")
    assert exit_code("validate", gait, "--log", log, "--out", str(out)) == 0
    assert "RMS torque 3 N m, planned 5.2" in capsys.readouterr().out
    assert json.loads(out.read_text())["log"]["samples"] == 325
    assert exit_code("validate", gait, "--log", log, "--case", "nominal", "--out", str(out)) == 2


@pytest.mark.parametrize("cell", ["1" * 200_000, "\r1"])
def test_what_the_csv_reader_refuses_is_one_sentence(cell: str, stabilised_gait: Gait, tmp_path: Path) -> None:
    log = written(stabilised_gait, tmp_path / "log.csv", 1.0, 0.0, 0.0)
    log.write_text(log.read_text().replace("100.004", cell, 1))
    with pytest.raises(InputError) as refused:
        read_log(log, stabilised_gait)
    assert "\n" not in str(refused.value)
