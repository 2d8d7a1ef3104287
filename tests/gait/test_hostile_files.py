"""Seeded damage to real gait files: each is refused in one sentence, or loads as a gait that can be saved again.

Every kind of section E.1, E.2, E.7 of the notes on hostile input is drawn: numbers and nesting, names, types, lengths,
keys, encodings, bytes.
"""

from __future__ import annotations

import copy
import json
import random
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import from_dict, load_gait, save_gait, to_dict
from amble.io.storage import dumps
from tests.seeds import seeds

FILE = Path(__file__).parents[1] / "data" / "format-3.json"

SCALARS: tuple[Any, ...] = (
    *(None, True, False, 0, -1, 1, 3, 10**9, 10**39, -(10**39), 0.0, -0.0, -1.5, 1e-308, 1e308, 5e-324),
    *("", "inf", "-inf", "nan", "fl", "D1", "m", "a\nb", "\x1b[31m", "\u202e", "*/", "\x00", "x" * 5000, "é"),
    *([], {}, [[]], [1.0], [None], {"value": 1.0}, {"value": 1.0, "unit": "m"}, {"name": "plane"}),
)

TEXTS = (
    *("9" * 5000, "1" + "0" * 400, "-" + "9" * 50, "1e999", "-1e999", "NaN", "Infinity", "01", "1.", "0x10", "1_0"),
    *("[" * 300 + "]" * 300, '{"a":' * 300 + "1" + "}" * 300, "[" * 100_000, '"\\ud800"', '{"\\udfff": 1}', "'a'"),
    *('{"value": 1' + "0" * 400 + ', "unit": "m"}', '{"value": [' + "9" * 4400 + '], "unit": "rad"}', "", "{", "]"),
)
"""Text in the place of a value, which ``json`` itself would not write."""

MARK = "@here@"


def places(tree: Any, path: tuple[Any, ...] = ()) -> Iterator[tuple[Any, ...]]:
    """Every place in a tree but inside lists of numbers, where a few stand for all."""
    yield path
    if isinstance(tree, dict):
        for key, value in tree.items():
            yield from places(value, (*path, key))
    elif isinstance(tree, list):
        for number in sorted({0, len(tree) // 2, len(tree) - 1} & set(range(len(tree)))):
            yield from places(tree[number], (*path, number))


def put(tree: Any, path: tuple[Any, ...], value: Any) -> None:
    for key in path[:-1]:
        tree = tree[key]
    tree[path[-1]] = value


def get(tree: Any, path: tuple[Any, ...]) -> Any:
    for key in path:
        tree = tree[key]
    return tree


def another_value(tree: Any, path: tuple[Any, ...], draw: random.Random) -> None:
    put(tree, path, copy.deepcopy(draw.choice(SCALARS)))


def gone(tree: Any, path: tuple[Any, ...], draw: random.Random) -> None:
    del draw
    del get(tree, path[:-1])[path[-1]]


def from_elsewhere(tree: Any, path: tuple[Any, ...], draw: random.Random) -> None:
    part = draw.choice(list(tree))
    put(tree, path, copy.deepcopy(get(tree[part], draw.choice(list(places(tree[part]))))))


def another_number(tree: Any, path: tuple[Any, ...], draw: random.Random) -> None:
    value = get(tree, path)
    if isinstance(value, int | float) and not isinstance(value, bool):
        change = draw.choice((-value, 0, value + 1, value - 1, value * 1e300, value / 2, float(value), int(value)))
        put(tree, path, change if abs(change) < 1e308 else 1e308)
    else:
        another_value(tree, path, draw)


def another_length(tree: Any, path: tuple[Any, ...], draw: random.Random) -> None:
    value = get(tree, path)
    if isinstance(value, list) and value:
        kinds: tuple[Any, ...] = (value[:-1], value + value[:1], [], value * 2, [value], value[0], value[::-1])
        put(tree, path, copy.deepcopy(draw.choice(kinds)))
    elif isinstance(value, dict) and value:
        key = draw.choice(list(value))
        value[draw.choice((key + " ", "extra", "", "a\nb", key.upper()))] = (
            value[key] if draw.random() < 0.5 else value.pop(key)
        )
    else:
        another_value(tree, path, draw)


DAMAGES: tuple[Callable[[Any, tuple[Any, ...], random.Random], None], ...] = (
    another_value,
    gone,
    from_elsewhere,
    another_number,
    another_length,
)


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


def drawn_place(tree: Any, draw: random.Random) -> tuple[Any, tuple[Any, ...]]:
    """Draw a part and a place in it, so that large parts do not hide small ones; the copy can be damaged there."""
    part = draw.choice(list(tree))
    copied = {**tree, part: copy.deepcopy(tree[part])}
    return copied, draw.choice(list(places(tree[part], (part,))))


@pytest.mark.parametrize("seed", seeds(4, 10))
def test_another_structure(seed: int, tree: Any) -> None:
    draw = random.Random(seed)
    refused = 0
    for _ in range(150):
        damaged, path = drawn_place(tree, draw)
        draw.choice(DAMAGES)(damaged, path, draw)
        text = sentence(lambda damaged=damaged: from_dict(damaged))
        assert_one_sentence(text)
        refused += bool(text)
    assert refused > 75  # most damage is seen; what is left are other numbers and names


@pytest.mark.parametrize("seed", seeds(2, 6))
def test_another_text(seed: int, tree: Any, tmp_path: Path) -> None:
    draw = random.Random(seed)
    for text in TEXTS:
        damaged, path = drawn_place(tree, draw)
        put(damaged, path, MARK)
        written = json.dumps({"format": "amble gait", "format_version": 3, **damaged})
        (tmp_path / "gait.json").write_text(written.replace(f'"{MARK}"', text))
        found = sentence(lambda: load_gait(tmp_path / "gait.json"))
        assert found
        assert_one_sentence(found)


@pytest.mark.parametrize("seed", seeds(2, 4))
def test_other_bytes(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    content = FILE.read_bytes()
    for _ in range(90):
        damaged = bytearray(content)
        at = draw.randrange(len(content))
        kind = draw.randrange(5)
        if kind == 0:
            damaged[at] ^= 1 << draw.randrange(8)
        elif kind == 1:
            damaged[at:] = b""
        elif kind == 2:
            damaged[at:at] = bytes(draw.randrange(256) for _ in range(draw.randrange(1, 9)))
        elif kind == 3:
            del damaged[at : at + draw.randrange(1, 2000)]
        else:
            other = draw.randrange(len(content))
            damaged[at : at + 50] = content[other : other + 50]
        (tmp_path / "gait.json").write_bytes(damaged)
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
