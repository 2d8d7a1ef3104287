"""A number of the command line that no work can use is one sentence and exit code 2, before the work."""

from __future__ import annotations

import inspect
from pathlib import Path
from typing import get_type_hints

import pytest

from amble.cli.app import app
from tests.cli.run import exit_code

DATA = Path(__file__).parents[1] / "data"
GAIT = str(DATA / "stabilised-amble.json")
BIPED = str(DATA / "biped-of-small-basin.json")
WHEEL = str(DATA.parents[1] / "examples" / "rimless_wheel.py")
HUGE = "9" * 30
WALKING = ("simulate", BIPED, "--cycles", "1")
PUSHED = ("robustness", GAIT)
MOVED = ("validate", GAIT, "--control", "impedance", "--case", "nominal")

NUMBERS: dict[tuple[str, str], tuple[tuple[str, ...], tuple[str, ...]]] = {
    ("check", "grid"): (("check", GAIT), ("0", "-1", "1001", "1e3", HUGE)),
    ("simulate", "cycles"): (("simulate", BIPED), ("0", "-1", "1.5", "nan", "1" + "0" * 20, "100000")),
    ("simulate", "tolerance"): (WALKING, ("-1", "nan", "1e400")),
    ("simulate", "perturb"): (WALKING, ("-1", "nan", "inf", "-inf")),
    ("simulate", "seed"): ((*WALKING, "--perturb", "1e-3"), ("-1", "1.5", f"-{HUGE}")),
    ("view", "cycles"): (("view", GAIT), ("0", "-1", "1001", HUGE)),
    ("reproduce", "cycles"): (("reproduce",), ("0", "-1", "x", "1" + "0" * 20)),
    ("reproduce", "tolerance"): (("reproduce",), ("0", "nan", "inf", "-1")),
    ("validate", "cycles"): (MOVED, ("0", "-1", "10001", "1" + "0" * 20)),
    ("validate", "seed"): ((*MOVED, "--cycles", "1"), ("-1", "1.5")),
    ("export", "cycles"): (("export", GAIT, "--rate", "100", "--out", "x.npz"), ("0", "-1", "1.5", "10001", HUGE)),
    ("robustness", "trials"): (PUSHED, ("0", "-1", "1.5", "10000001", HUGE)),
    ("robustness", "seed"): (PUSHED, ("-1", "1.5")),
    ("robustness", "cycles"): (PUSHED, ("1", "-1", "10001", HUGE)),
    ("robustness", "friction"): (PUSHED, ("0", "-1", "nan", "inf")),
    ("robustness", "largest"): (PUSHED, ("0", "-1", "nan", "inf")),
    ("robustness", "workers"): (PUSHED, ("0", "-1", "257", HUGE)),
    ("steer", "duration"): (("steer", "library", "--commands", "x.csv"), ("0", "-1", "nan", "inf", "1e6", HUGE)),
    ("transitions", "friction"): (("transitions", "library"), ("0", "-1", "nan", "inf")),
    ("front", "friction"): (("front", GAIT), ("0", "-1", "nan", "inf")),
    ("front", "bears"): (("front", GAIT), ("0", "-1", "nan", "inf")),
    ("prove", "bits"): (("prove", f"{WHEEL}:rolling"), ("0", "63", "1025", HUGE)),
    ("prove", "order"): (("prove", f"{WHEEL}:rolling"), ("3", "41", HUGE)),
    ("prove", "basin"): (("prove", f"{WHEEL}:rolling"), ("-1", "2", "nan", "inf")),
}

OPTIONAL = {
    ("prove", "bits"), ("prove", "order"), ("prove", "basin"),
    ("transitions", "friction"), ("front", "bears"), ("export", "cycles"),
}  # fmt: skip
"""Numbers that may be left out, so that what is worked on says them."""


def test_every_number_of_every_command_is_tried() -> None:
    commands = {
        command.name or getattr(command.callback, "__name__", ""): command.callback
        for command in app.registered_commands
    }
    found = {
        (name, option)
        for name, callback in commands.items()
        for option, kind in get_type_hints(inspect.unwrap(callback)).items()
        if kind in (int, float)
    }
    assert found | OPTIONAL == set(NUMBERS)


@pytest.mark.parametrize("place", NUMBERS, ids="-".join)
def test_a_number_out_of_range_is_one_sentence(
    place: tuple[str, str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """A grid of 10^20 points and a seed of -1 ended in tracebacks, 10^20 cycles never; a tolerance was refused late."""
    monkeypatch.chdir(tmp_path)
    arguments, values = NUMBERS[place]
    for value in values:
        assert exit_code(*arguments, f"--{place[1]}", value) == 2, value
        said = capsys.readouterr().err.splitlines()
        assert "error" in said[-1].lower()
    assert not list(tmp_path.iterdir())
