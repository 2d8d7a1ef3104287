"""Format version 3: a file of the day it was fixed reads the same for ever, and its page names every key."""

from __future__ import annotations

import json
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from amble.gait.files import content_hash, load_gait, save_gait

FILE = Path(__file__).parents[1] / "data" / "format-3.json"
PAGE = Path(__file__).parents[2] / "docs" / "gait-format.md"

ROBOT = "98c6493a1059ca06a61ba871d28a99e63dc2c4facca372d4beceaaa3f86778c8"
CONTENT = "97999afd32442d3283d744f00e318e4e3b20cec4224f9c86c53e9757354dd220"


def test_a_file_of_the_first_day_has_its_hashes_for_ever() -> None:
    gait = load_gait(FILE)
    assert gait.robot.hash == ROBOT
    assert content_hash(gait) == CONTENT


def test_it_is_written_again_byte_for_byte(tmp_path: Path) -> None:
    assert save_gait(load_gait(FILE), tmp_path / "gait.json").read_bytes() == FILE.read_bytes()


def test_the_content_is_all_that_moves(tmp_path: Path) -> None:
    """How a gait was found and how its file is laid out do not count; everything else does."""
    tree = json.loads(FILE.read_text())
    tree["solver"]["iterations"] += 1
    tree["versions"]["amble"] = "9"
    del tree["multipliers"]
    again = tmp_path / "gait.json"
    again.write_text(json.dumps(dict(reversed(tree.items()))))
    assert content_hash(load_gait(again)) == CONTENT
    for part, number in (("ground", "friction"), ("control_law", "position_gain"), ("limits", "clearance")):
        changed = json.loads(FILE.read_text())
        place = changed[part].get("parameters", changed[part])
        place[number]["value"] *= 2.0
        again.write_text(json.dumps(changed))
        assert content_hash(load_gait(again)) != CONTENT


def keys(tree: Any) -> Iterator[str]:
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield key
            yield from keys(value)
    elif isinstance(tree, list):
        for value in tree:
            yield from keys(value)


def test_the_page_names_every_key() -> None:
    gait = load_gait(FILE)
    named = set(re.findall(r"`([A-Za-z_0-9.]+)`", PAGE.read_text(encoding="utf-8")))
    names = {*gait.robot.coordinate_names, *(stance.name for stance in gait.pattern.stances)}
    structure = {"value", "unit", "units"}  # in the rules above the tables
    assert set(keys(json.loads(FILE.read_text()))) - named - names - structure == set()
