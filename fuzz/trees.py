"""Damage to trees of dictionaries, lists and leaves: types, numbers, names, keys, shapes, parts from elsewhere."""

from __future__ import annotations

import copy
import json
import math
import random
from collections.abc import Callable
from typing import Any

from fuzz.words import LITERALS, MARK, NAMES, SCALARS

Path = tuple[Any, ...]


CHANGES: tuple[Callable[[Any], Any], ...] = (
    *(lambda x: -x, lambda x: 0 * x, lambda x: x + 1, lambda x: x * 1e150, lambda x: x * 1e-200),
    *(lambda x: x * 1.001, lambda x: x / 3, float, lambda x: int(x) if math.isfinite(x) else x),
)
"""Of one number."""


def get(tree: Any, path: Path) -> Any:
    """Return what is at a place."""
    for key in path:
        tree = tree[key]
    return tree


def put(tree: Any, path: Path, value: Any) -> None:
    """Put a value at a place other than the root."""
    get(tree, path[:-1])[path[-1]] = value


def drawn_place(tree: Any, draw: random.Random) -> Path:
    """Draw a place, level by level, so that large parts do not hide small ones."""
    path: Path = ()
    while True:
        value = get(tree, path)
        keys = list(value) if isinstance(value, dict) else list(range(len(value))) if isinstance(value, list) else []
        if not keys or (path and draw.random() < 0.15):
            return path
        path = (*path, draw.choice(keys))


def another_value(tree: Any, path: Path, draw: random.Random) -> None:
    """A scalar or a small tree of any type."""
    put(tree, path, copy.deepcopy(draw.choice(SCALARS)))


def literal(tree: Any, path: Path, draw: random.Random) -> None:
    """Text that the writer would not write."""
    put(tree, path, MARK + str(draw.randrange(len(LITERALS))))


def gone(tree: Any, path: Path, draw: random.Random) -> None:
    """A missing key or entry."""
    del draw
    del get(tree, path[:-1])[path[-1]]


def from_elsewhere(tree: Any, path: Path, draw: random.Random) -> None:
    """A part of the same tree in another place."""
    put(tree, path, copy.deepcopy(get(tree, drawn_place(tree, draw))))


def another_number(tree: Any, path: Path, draw: random.Random) -> None:
    """A number that is a little or very different; numbers in whole lists together."""
    value = get(tree, path)
    change = draw.choice(CHANGES)

    def apply(entry: Any) -> Any:
        if isinstance(entry, list):
            return [apply(one) for one in entry]
        if isinstance(entry, bool) or not isinstance(entry, int | float):
            return entry
        try:
            return change(entry)
        except OverflowError:
            return entry

    if isinstance(value, list | int | float) and not isinstance(value, bool):
        put(tree, path, apply(value))
    else:
        another_value(tree, path, draw)


def another_name(tree: Any, path: Path, draw: random.Random) -> None:
    """Another text, here or wherever the old one stands, keys included."""
    value, name = get(tree, path), draw.choice(NAMES)
    if not isinstance(value, str):
        keys = [key for key in value if isinstance(key, str)] if isinstance(value, dict) else []
        if not keys:
            return another_value(tree, path, draw)
        value = draw.choice(keys)
    elif draw.random() < 0.5:
        return put(tree, path, name)

    def renamed(entry: Any) -> Any:
        if isinstance(entry, dict):
            return {name if key == value else key: renamed(one) for key, one in entry.items()}
        if isinstance(entry, list):
            return [renamed(one) for one in entry]
        return name if entry == value else entry

    for key in list(tree):
        tree[key] = renamed(tree[key])
    return None


def another_length(tree: Any, path: Path, draw: random.Random) -> None:
    """A list of another length or nesting; an unknown or doubled key."""
    value = get(tree, path)
    if isinstance(value, list) and value:
        kinds: tuple[Any, ...] = (value[:-1], value + value[:1], [], value * 2, [value], value[0], value[::-1])
        put(tree, path, copy.deepcopy(draw.choice(kinds)))
    elif isinstance(value, dict) and value:
        key = draw.choice(list(value))
        new = draw.choice((f"{key} ", "extra", "", "a\nb", str(key).upper(), draw.choice(NAMES)))
        value[new] = copy.deepcopy(value[key]) if draw.random() < 0.5 else value.pop(key)
    else:
        another_value(tree, path, draw)


def swapped(tree: Any, path: Path, draw: random.Random) -> None:
    """Two entries of one list or object in each other's place."""
    holder = get(tree, path[:-1])
    other = draw.choice(list(holder) if isinstance(holder, dict) else list(range(len(holder))))
    holder[path[-1]], holder[other] = holder[other], holder[path[-1]]


DAMAGES: tuple[Callable[[Any, Path, random.Random], None], ...] = (
    *(another_value, another_value, another_number, another_number, another_number, another_name, another_name),
    *(another_length, another_length, literal, gone, from_elsewhere, swapped),
)


def damage(tree: Any, draw: random.Random) -> str:
    """Change one thing in a tree (a dictionary) and return what."""
    path = drawn_place(tree, draw)
    if not path:
        return "nothing"
    kind = draw.choice(DAMAGES)
    kind(tree, path, draw)
    return f"{kind.__name__} at {'.'.join(map(str, path))}"


def with_literals(text: str, draw: random.Random) -> str:
    """Replace the marks of a written tree by their literals, and now and then a key by the one before."""
    for number, text_of in enumerate(LITERALS):
        text = text.replace(f'"{MARK}{number}"', text_of)
    if draw.random() < 0.02:
        text = text.replace('"unit":', '"value":', 1)
    return text


def as_json(tree: Any, draw: random.Random) -> bytes:
    """Write a tree as JSON."""
    return with_literals(json.dumps(tree), draw).encode("utf-8", "surrogatepass")
