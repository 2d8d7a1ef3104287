"""``--json`` is one object on standard output whatever happens, ``--quiet`` is silence but for errors."""

from __future__ import annotations

import json
import logging
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amble.cli import robots
from amble.cli.output import plain
from tests.cli.run import exit_code

GAIT = str(Path(__file__).parents[1] / "data" / "stabilised-amble.json")
BIPED = str(Path(__file__).parents[1] / "data" / "biped-of-small-basin.json")
"""Certified in half the time."""

COMMANDS = {
    "robots": (["robots"], "robots"),
    "check": (["check", GAIT], "worst"),
    "simulate": (["simulate", GAIT, "--cycles", "1", "--out", "OUT"], "simulation"),
    "compare": (["compare", GAIT, "--law", "pinv", "--out", "OUT"], "allocation"),
    "export": (["export", GAIT, "--out", "OUT"], "law"),
    "certify": (["certify", BIPED, "--out", "OUT"], "certificate"),
    "view": (["view", GAIT, "--html", "OUT"], "replay"),
}


@pytest.mark.parametrize("name", COMMANDS)
def test_json_is_all_that_is_printed(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments, key = COMMANDS[name]
    out = tmp_path / "out"
    places = [str(out) if word == "OUT" else word for word in arguments]
    assert exit_code(*places, "--json") == 0
    tree: dict[str, Any] = json.loads(capsys.readouterr().out)
    assert tree["command"] == name
    assert tree["exit_code"] == 0
    assert tree["error"] is None
    assert tree[key]
    assert all(Path(path).exists() for path in tree["wrote"])
    assert bool(tree["wrote"]) == ("OUT" in arguments)


@pytest.mark.parametrize("name", ["robots", "simulate", "compare"])
def test_quiet_says_nothing(name: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments, _ = COMMANDS[name]
    places = [str(tmp_path / "out") if word == "OUT" else word for word in arguments]
    assert exit_code(*places, "--quiet") == 0
    assert capsys.readouterr() == ("", "")
    assert ("OUT" in arguments) == any(tmp_path.iterdir())


def test_bad_input_is_one_object_and_one_sentence(capsys: pytest.CaptureFixture[str]) -> None:
    assert exit_code("check", "none.json", "--json", "--quiet") == 2
    captured = capsys.readouterr()
    tree = json.loads(captured.out)
    assert tree["exit_code"] == 2
    assert tree["error"]["kind"] == "InputError"
    assert captured.err == f"error: {tree['error']['message']}\n"
    assert tree["wrote"] == []


def test_failed_work_keeps_what_was_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    out = tmp_path / "trace.nc"
    command = ("simulate", GAIT, "--cycles", "5", "--perturb", "0.5", "--out", str(out))
    assert exit_code(*command, "--json") == 1
    tree = json.loads(capsys.readouterr().out)
    assert tree["error"]["kind"] == "FallError"
    assert tree["simulation"]["ended"] == tree["error"]["message"]
    assert tree["wrote"] == [str(out)]


def test_an_interrupt_is_one_object_too(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    def interrupted(*_: object, **__: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr(robots, "print_table", interrupted)
    assert exit_code("robots", "--json") == 130
    tree = json.loads(capsys.readouterr().out)
    assert tree["exit_code"] == 130
    assert tree["error"] == {"kind": "KeyboardInterrupt", "message": "interrupted"}


def test_quiet_is_not_kept_for_the_next_command(capsys: pytest.CaptureFixture[str]) -> None:
    level = logging.getLogger("amble").level
    assert exit_code("robots", "--quiet") == 0
    assert exit_code("robots") == 0
    assert "astro" in capsys.readouterr().out
    assert logging.getLogger("amble").level == level


def test_any_tree_becomes_plain_json() -> None:
    tree = {1: (np.float64(0.5), float("inf"), None, True), "path": Path("a"), "int": np.int64(3)}
    assert plain(tree) == {"1": [0.5, None, None, True], "path": "a", "int": 3}
