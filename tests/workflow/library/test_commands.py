"""Commands over time as a file, and steered walks as tables."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError
from amble.simulation.steering import Steered, SteeredStep
from amble.workflow.library.commands import read_commands, write_steered


def test_columns_come_in_any_order(tmp_path: Path) -> None:
    path = tmp_path / "commands.csv"
    path.write_text("height, time ,speed\n0.34,0,0.1\n\n0.35,2.5,2e-1\n", encoding="utf-8")
    assert read_commands(path, ("speed", "height")) == [(0.0, (0.1, 0.34)), (2.5, (0.2, 0.35))]


@pytest.mark.parametrize(
    ("text", "sentence"),
    [
        ("", "are empty"),
        ("time\n0\n", "first line"),
        ("time,speed,speed\n0,1,1\n", "first line"),
        ("time,velocity\n0,1\n", "first line"),
        ("time,speed\n0\n", "row 2: 1 entries, not 2"),
        ("time,speed\n0,fast\n", "row 2: 'fast' is not a number"),
        ("time,speed\n0,6_0\n", "not a number"),
        ('time,speed\n0,"1\n', "commands"),
    ],
)
def test_what_is_no_file_of_commands_is_one_sentence(tmp_path: Path, text: str, sentence: str) -> None:
    path = tmp_path / "commands.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=sentence) as refused:
        read_commands(path, ("speed",))
    assert "\n" not in str(refused.value)


def test_a_steered_walk_is_a_row_a_step(tmp_path: Path) -> None:
    steps = tuple(
        SteeredStep(time=0.1 * k, asked=(0.3,), command=(0.1 * k,), state=np.array([k, -k]), irregular=k)
        for k in range(2)
    )
    found = Steered(
        axes=("speed",), state_names=("x", "d x"), steps=steps, time=0.2, state=np.zeros(2), ended="completed"
    )
    rows = list(csv.DictReader(write_steered(found, tmp_path / "steered.csv").read_text().splitlines()))
    assert rows[1] == {
        "time": "0.1", "asked_speed": "0.3", "followed_speed": "0.1", "irregular_contacts": "1", "x": "1.0",
        "d x": "-1.0",
    }  # fmt: skip
