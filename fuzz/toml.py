"""A tree as TOML; the standard library only reads it."""

from __future__ import annotations

import json
import re
from typing import Any

BARE = re.compile(r"[A-Za-z0-9_-]+", re.ASCII)


def as_toml(tree: dict[str, Any]) -> str:
    """Write every table of the first level as a section, what lies deeper inline; None is left out."""
    top = [f"{_key(key)} = {_value(value)}" for key, value in tree.items() if not isinstance(value, dict)]
    for key, table in tree.items():
        if isinstance(table, dict):
            top += [f"[{_key(key)}]", *(f"{_key(inner)} = {_value(value)}" for inner, value in table.items())]
    return "\n".join(top) + "\n"


def _key(key: Any) -> str:
    return str(key) if BARE.fullmatch(str(key)) else json.dumps(str(key))


def _value(value: Any) -> str:
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{_key(key)} = {_value(inner)}" for key, inner in value.items()) + " }"
    if isinstance(value, list):
        return "[" + ", ".join(map(_value, value)) + "]"
    if value is None:
        return "[]"
    if isinstance(value, float):
        return repr(value)
    return json.dumps(value)
