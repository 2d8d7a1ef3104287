"""Seeded damage to real gait files: each is refused in one sentence, or loads as a gait that can be saved again.

The damage is the fuzzer's: numbers and nesting, names, types, lengths, keys, encodings, bytes.
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import from_dict, load_gait, save_gait, to_dict
from amble.io.storage import dumps
from fuzz.bytes import damaged
from fuzz.trees import as_json, damage, drawn_place, literal
from fuzz.words import LITERALS
from tests.seeds import seeds

FILE = Path(__file__).parents[1] / "data" / "format-3.json"


def sentence(load: Callable[[], Gait]) -> str:
    """Return why a gait is refused; one that is not must be whole enough to be written again."""
    try:
        gait = load()
    except InputError as error:
        return str(error)
    to_dict(gait)
    return ""


def assert_one_sentence(text: str) -> None:
    assert text.isprintable(), text
    assert len(text) < 5000


@pytest.fixture(scope="module")
def tree() -> Any:
    found = json.loads(FILE.read_text())
    del found["format"], found["format_version"]
    return found


@pytest.mark.parametrize("seed", seeds(2, 10))
def test_another_structure(seed: int, tree: Any) -> None:
    draw = random.Random(seed)
    refused = 0
    for _ in range(150):
        damaged_tree = copy.deepcopy(tree)
        damage(damaged_tree, draw)
        text = sentence(lambda damaged_tree=damaged_tree: from_dict(damaged_tree))
        assert_one_sentence(text)
        refused += bool(text)
    assert refused > 75  # most damage is seen; what is left are other numbers and names


@pytest.mark.parametrize("seed", seeds(2, 6))
def test_another_text(seed: int, tree: Any, tmp_path: Path) -> None:
    draw = random.Random(seed)
    refused = 0
    for _ in LITERALS:
        damaged_tree = {"format": "amble gait", "format_version": 3, **copy.deepcopy(tree)}
        literal(damaged_tree, drawn_place(tree, draw), draw)
        (tmp_path / "gait.json").write_bytes(as_json(damaged_tree, draw))
        text = sentence(lambda: load_gait(tmp_path / "gait.json"))
        assert_one_sentence(text)
        refused += bool(text)
    assert refused > len(LITERALS) // 2  # the rest are numbers


@pytest.mark.parametrize("seed", seeds(2, 4))
def test_other_bytes(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    content = FILE.read_bytes()
    for _ in range(90):
        (tmp_path / "gait.json").write_bytes(damaged(content, draw)[0])
        assert_one_sentence(sentence(lambda: load_gait(tmp_path / "gait.json")))


@pytest.mark.parametrize("encoding", ["utf-16", "utf-16-le", "utf-32", "cp037"])
def test_other_encodings_are_refused(encoding: str, tmp_path: Path) -> None:
    (tmp_path / "gait.json").write_bytes(FILE.read_text().encode(encoding))
    with pytest.raises(InputError, match=r"is not text in UTF-8|is not JSON"):
        load_gait(tmp_path / "gait.json")


def test_a_byte_order_mark_is_read_over(tmp_path: Path) -> None:
    (tmp_path / "gait.json").write_bytes(FILE.read_text().encode("utf-8-sig"))
    assert dumps(to_dict(load_gait(tmp_path / "gait.json"))) == dumps(to_dict(load_gait(FILE)))


@pytest.mark.parametrize("name", ["\ud800", "a\udfffb"])
def test_half_a_character_in_a_name_is_not_written(name: str, tmp_path: Path) -> None:
    gait = load_gait(FILE)
    with pytest.raises(InputError, match="characters that cannot be printed"):
        save_gait(replace(gait, pattern=replace(gait.pattern, name=name)), tmp_path / "gait.json")
    assert not list(tmp_path.iterdir())
