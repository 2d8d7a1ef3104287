"""Seeded damage to a real URDF: a robot, or one sentence."""

from __future__ import annotations

import random
import re
from pathlib import Path

import pytest

from amble.errors import InputError
from amble.robot import load_robot
from tests.robots import path

CONTENT = path("astro").read_bytes()
FEET = {"fl": "fl_foot", "fr": "fr_foot"}

VALUES = (
    *("", " ", "0", "-1", "1e400", "-1e999", "nan", "inf", "6_0", "٣", "1 2", "1 2 3", "0 0 0"),
    *("nan nan nan", "9" * 5000, "1e308 1e308 1e308", "a\tb", "&#10;", "&amp;", "&#xD800;", "&bomb;", "x" * 5000),
    *("fixed", "floating", "prismatic", "body", "fl_foot"),
)

DECLARATIONS = (
    *(b"", b"\n\n", b"\xef\xbb\xbf", b"<!-- -->", b"<?xml", b"\x00", b"<!DOCTYPE a [<!ENTITY b 'c'>]>"),
    *(b'<?xml version="1.0"?>', b'<?xml version="9" encoding="latin-1"?>'),
    *(f'<?xml version="1.0" encoding="{name}"?>'.encode() for name in ("gb2312", "utf-16", "rot13", "hex", "idna")),
)


def damaged(draw: random.Random) -> bytes:
    """Return the file with one thing changed."""
    kind = draw.randrange(6)
    body = CONTENT[CONTENT.index(b"<robot") :]
    if kind == 0:
        return draw.choice(DECLARATIONS) + draw.choice(DECLARATIONS) + body
    if kind == 1:
        return body.decode().encode(draw.choice(("utf-16", "utf-16-le", "utf-32", "cp037", "utf-8-sig")))
    if kind == 2:
        changed = bytearray(CONTENT)
        changed[draw.randrange(len(changed))] = draw.randrange(256)
        return bytes(changed)
    quoted = list(re.finditer(rb'"[^"<>]*"', body))
    at = draw.choice(quoted)
    value = draw.choice(VALUES).encode() if kind < 5 else draw.choice(quoted).group().strip(b'"')
    return body[: at.start()] + b'"' + value + b'"' + body[at.end() :]


def sentence(file: Path) -> str:
    """Return why a robot is refused, nothing where it is read."""
    try:
        load_robot(file, FEET)
    except InputError as error:
        return str(error)
    return ""


@pytest.mark.parametrize("seed", range(5))
def test_a_damaged_urdf(seed: int, tmp_path: Path) -> None:
    draw = random.Random(seed)
    refused = 0
    for _ in range(80):
        (tmp_path / "robot.urdf").write_bytes(damaged(draw))
        text = sentence(tmp_path / "robot.urdf")
        assert "\n" not in text
        refused += bool(text)
    assert refused > 20


@pytest.mark.parametrize("attribute", ["mass value", "inertia ixx", "origin xyz", "axis xyz"])
def test_numbers_that_no_robot_has_are_refused(attribute: str, tmp_path: Path) -> None:
    """Products of them would not be finite, and the sentence would be about something else."""
    key = attribute.split()[1]
    text = re.sub(rf'(<{attribute.split(maxsplit=1)[0]}[^>]* {key}=")[^ "]*', r"\g<1>1e200", CONTENT.decode(), count=1)
    assert "1e200" in text
    (tmp_path / "robot.urdf").write_text(text)
    with pytest.raises(InputError, match="numbers of a robot go up to 1e\\+12"):
        load_robot(tmp_path / "robot.urdf", FEET)


def test_a_very_short_axis_is_a_direction(tmp_path: Path) -> None:
    text = re.sub(r'axis xyz="[^"]*"', 'axis xyz="0 1e-200 0"', CONTENT.decode(), count=1)
    (tmp_path / "robot.urdf").write_text(text)
    assert list(load_robot(tmp_path / "robot.urdf", FEET).joints[0].axis) == [0.0, 1.0, 0.0]
