"""XML of others: what declares entities is refused before it is parsed, in every encoding that the parser knows."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from amble.errors import InputError
from amble.io.xml import parse_xml
from amble.robot.mjcf_model import _named
from amble.robot.srdf import read_srdf
from amble.robot.urdf import read_urdf
from amble.view.mesh_files import read_mesh

BOMB = f'<!DOCTYPE a [<!ENTITY e "{"x" * 1000}\N{LEG}">]><robot name="{"&e;" * 90}"/>'


def test_plain_xml_is_parsed() -> None:
    assert parse_xml("<!DOCTYPE robot><robot name='a &amp; b'/>").get("name") == "a & b"
    assert parse_xml('<?xml version="1.0" encoding="latin-1"?><a b="\xe9"/>'.encode("latin-1")).get("b") == "\xe9"


@pytest.mark.parametrize("encoding", ["utf-8", "utf-16", "utf-16-be"])
def test_entities_are_refused(encoding: str) -> None:
    with pytest.raises(ValueError, match="declares an entity"):
        parse_xml(BOMB.encode(encoding))
    with pytest.raises(ValueError, match="declares an entity"):
        parse_xml(BOMB)


@pytest.mark.parametrize(
    ("suffix", "read"),
    [
        (".urdf", read_urdf),
        (".srdf", read_srdf),
        (".dae", read_mesh),
        (".xml", lambda path: _named(path.read_bytes(), "the file")),
    ],
)
def test_every_reader_of_xml_refuses_them(suffix: str, read: Callable[[Path], object], tmp_path: Path) -> None:
    path = tmp_path / f"file{suffix}"
    path.write_text(BOMB, encoding="utf-8")
    with pytest.raises(InputError, match="declares an entity") as refused:
        read(path)
    assert len(str(refused.value)) < 500
