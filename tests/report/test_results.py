"""results.json: keys, finiteness, atomic writing."""

from __future__ import annotations

import json
from pathlib import Path

import casadi
import numpy as np
import pytest
import scipy

import amble
from amble.errors import WorkError
from amble.report import write_results
from amble.report.results import computing_versions


def test_what_is_written_is_what_is_read(tmp_path: Path) -> None:
    tree = {"a": {"b": [1, 2.5, None, True, "text"]}, "µ": 0.1 + 0.2}
    path = write_results(tmp_path / "deep" / "results.json", tree)
    assert json.loads(path.read_text(encoding="utf-8")) == tree


@pytest.mark.parametrize(
    ("tree", "place"),
    [
        ({"a": {"b": float("nan")}}, "'a.b' is nan"),
        ({"a": [0.0, float("inf")]}, r"'a\[1\]' is inf"),
        ({"a": np.zeros(2)}, "'a' is of type ndarray"),
        ({"a": {3: 1.0}}, "key below 'a' is 3"),
    ],
)
def test_what_json_cannot_hold_is_named_and_nothing_is_written(tmp_path: Path, tree: dict, place: str) -> None:
    path = tmp_path / "results.json"
    write_results(path, {"good": 1.0})
    with pytest.raises(WorkError, match=place):
        write_results(path, tree)
    assert json.loads(path.read_text()) == {"good": 1.0}
    assert [entry.name for entry in tmp_path.iterdir()] == ["results.json"]


def test_the_versions_are_those_of_what_is_loaded() -> None:
    found = computing_versions()
    loaded = {"amble": amble, "casadi": casadi, "numpy": np, "scipy": scipy}
    assert {name: found[name] for name in loaded} == {name: module.__version__ for name, module in loaded.items()}
    assert all(found.values())


def test_without_a_compiler_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    assert computing_versions()["C compiler"] == "none, interpreted"
