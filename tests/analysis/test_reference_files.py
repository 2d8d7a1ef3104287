"""Files of reference motions, and the command that writes them."""

from __future__ import annotations

import csv
import itertools
from pathlib import Path

import numpy as np
import pytest

from amble.analysis.reference import ReferenceMotion, reference_motion
from amble.analysis.reference_files import write_reference
from amble.gait import Gait
from tests.cli.run import exit_code

DATA = Path(__file__).parents[1] / "data"


@pytest.fixture(scope="module")
def motion(walking_gait: Gait) -> ReferenceMotion:
    return reference_motion(walking_gait, 500.0, cycles=2)


def test_a_table_has_a_column_a_number(motion: ReferenceMotion, tmp_path: Path) -> None:
    rows = list(csv.DictReader(write_reference(motion, tmp_path / "motion.csv").read_text().splitlines()))
    assert len(rows) == len(motion.time)
    assert [float(row["time"]) for row in rows] == motion.time.tolist()
    assert [float(row["qw"]) for row in rows] == motion.qpos[:, 3].tolist()
    last = motion.joints[-1]
    assert [float(row[f"torque {last}"]) for row in rows] == motion.torques[:, -1].tolist()
    assert {row[f"contact {motion.feet[0]}"] for row in rows} == {"0", "1"}
    assert [name for name, _ in itertools.groupby(row["stance"] for row in rows)] == [
        name for name, _ in itertools.groupby(motion.stances)
    ]


def test_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    gait = str(DATA / "stabilised-amble.json")
    place = tmp_path / "motion.npz"
    assert exit_code("export", gait, "--rate", "100", "--order", "file", "--out", str(place)) == 0
    with np.load(place) as file:
        assert file["qpos"].shape[1] == 7 + len(file["joints"])
    assert exit_code("export", gait, "--rate", "100", "--out", str(tmp_path / "motion.mat")) == 2
    assert "known: .npz, .csv, .mcap" in capsys.readouterr().err
    assert exit_code("export", gait, "--rate", "100", "--law", "pinv", "--out", str(place)) == 2
    assert exit_code("export", gait, "--out", str(tmp_path / "motion.mcap")) == 2
    assert "needs --rate" in capsys.readouterr().err
