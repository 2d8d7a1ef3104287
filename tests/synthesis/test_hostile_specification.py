"""Seeded damage to the shipped specification: read, or refused in one sentence."""

from __future__ import annotations

import random
import re
from importlib import resources
from pathlib import Path

import pytest

from amble.errors import InputError
from amble.synthesis.specification import read_specification

TEXT = (resources.files("amble.specifications") / "astro-amble.toml").read_text(encoding="utf-8")

VALUES = (
    *("", "1", "-1", "0.0", "-0", "nan", "inf", "-inf", "1e400", "true", "1979-05-27", "07:32:00"),
    *('""', '"m"', '"1"', '"1 m"', '"1 deg"', '"1_0 m"', '"٣ m"', '"inf m/s"', '"1e999 s"', '"nan rad"'),
    *('"\\u0000"', '"a\\nb"', '"\\ud800"', "'''\n'''", "9" * 40, "9" * 5000, "1" + "0" * 400, "0x" + "f" * 99),
    *("[]", "[1]", "[1, 2]", "[2, 1]", "[[1]]", "[" * 500 + "]" * 500, '["fl_knee"]'),
    *("{}", "{ a = 1 }", "{ a = " * 50 + "1" + " }" * 50),
    *('{ D1 = ["fl_knee"] }', "{ fl_knee = [0, 1] }", "{ D1 = [0, 1] }"),
)

KEYS = ("a", '"a\\nb"', '""', "a.b.c", ".".join("a" * 300), "robot", "limits", "é", '"\\u202e"')


def damaged(draw: random.Random) -> bytes:
    """Return the file with one thing changed."""
    lines = TEXT.splitlines()
    number = draw.choice([n for n, line in enumerate(lines) if "=" in line and not line.startswith("#")])
    key, _, value = lines[number].partition("=")
    kind = draw.randrange(6)
    if kind == 0:
        lines[number] = f"{draw.choice(KEYS)} = {value}"
    elif kind == 1:
        lines.insert(number, draw.choice(("[limits]", "[[gait]]", "[a.b]", lines[number], f"[{draw.choice(KEYS)}]")))
    elif kind == 2:
        other = draw.choice(VALUES)
        lines[number] = f"{key} = {re.sub('[0-9.]+', lambda _: other, value)}"
    elif kind == 3:
        content = bytearray(TEXT.encode())
        content[draw.randrange(len(content))] = draw.randrange(256)
        return bytes(content)
    else:
        lines[number] = f"{key} = {draw.choice(VALUES)}"
    return "\n".join(lines).encode()


def sentence(path: Path) -> str:
    """Return why a specification is refused, nothing where it is read."""
    try:
        read_specification(path)
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("seed", range(5))
def test_a_damaged_specification(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    refused = 0
    for _ in range(100):
        (tmp_path / "spec.toml").write_bytes(damaged(draw))
        text = sentence(tmp_path / "spec.toml")
        assert text.isprintable(), text
        assert len(text) < 1000
        refused += bool(text)
    assert refused > 50
