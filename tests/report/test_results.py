"""results.json: keys, finiteness, atomic writing."""

import json
from pathlib import Path

import numpy as np
import pytest

from amble.errors import WorkError
from amble.report import write_results


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
