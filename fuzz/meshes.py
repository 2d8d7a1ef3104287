"""Mesh files with damage: one solid in three formats, its words and bytes replaced."""

from __future__ import annotations

import random
import struct
from collections.abc import Callable
from pathlib import Path
from typing import Any

from fuzz.bytes import damaged

POINTS = ((0.0, 0.0, 0.0), (0.3, 0.0, 0.0), (0.0, 0.2, 0.0), (0.0, 0.0, 0.1))
FACES = ((0, 2, 1), (0, 1, 3), (1, 2, 3), (0, 3, 2))

WORDS = (
    "0",
    "-1",
    "4",
    "99999999999999999999",
    "1e308",
    "1e999",
    "nan",
    "x",
    "",
    "2147483648",
    "1/2/3",
    "#n",
    "#g",
    "g",
)


def _spaced(*words: object) -> str:
    return " ".join(map(str, words))


OBJ = "\n".join(
    [*(_spaced("v", *point) for point in POINTS), *(_spaced("f", *(k + 1 for k in face)) for face in FACES)]
)

TEXT_STL = _spaced(
    "solid s", *(_spaced("outer loop", *(_spaced("vertex", *POINTS[k]) for k in face), "endloop") for face in FACES)
)

BINARY_STL = (
    b"".ljust(80)
    + struct.pack("<I", len(FACES))
    + b"".join(struct.pack("<12fH", 0, 0, 0, *(value for k in face for value in POINTS[k]), 0) for face in FACES)
)

DAE = """<COLLADA xmlns="http://www.collada.org/2005/11/COLLADASchema">
<asset> <unit meter="0.001" /> <up_axis> Z_UP </up_axis> </asset>
<library_geometries> <geometry id="g" > <mesh>
<source id="p" > <float_array> 0 0 0 300 0 0 0 200 0 0 0 100 </float_array> </source>
<vertices id="v" > <input semantic="POSITION" source="#p" /> </vertices>
<polylist> <input semantic="VERTEX" source="#v" offset="0" /> <vcount> 3 3 3 3 </vcount>
<p> 0 2 1 0 1 3 1 2 3 0 3 2 </p> </polylist> </mesh> </geometry> </library_geometries>
<library_visual_scenes> <visual_scene> <node id="n" > <rotate> 0 0 1 90 </rotate> <instance_geometry url="#g" />
<instance_node url="#m" /> <instance_node url="#m" /> </node>
<node id="m" > <scale> 1 2 3 </scale> <instance_geometry url="#g" /> </node>
</visual_scene> </library_visual_scenes> </COLLADA>"""


def _drawn(text: str, draw: random.Random) -> tuple[bytes, list[str]]:
    words, done = text.split(" "), []
    for _ in range(draw.choice((1, 1, 1, 2, 3, 5))):
        plain = [k for k, word in enumerate(words) if not set(word) & set('<>="')]  # damage elsewhere breaks the XML
        at = draw.choice(plain) if draw.random() < 0.8 else draw.randrange(len(words))
        kind = draw.choice(("word", "word", "other", "gone", "twice"))
        if kind == "word":
            words[at] = draw.choice(WORDS)
        elif kind == "other":
            words[at] = draw.choice(words)
        else:
            words[at : at + 1] = [] if kind == "gone" else 2 * words[at : at + 1]
        done.append(kind)
    return _then_bytes(" ".join(words).encode(), done, draw)


def _then_bytes(content: bytes, done: list[str], draw: random.Random) -> tuple[bytes, list[str]]:
    if draw.random() < 0.12:
        content, what = damaged(content, draw)
        done.append(what)
    return content, done


def draw_stl(draw: random.Random) -> tuple[bytes, list[str]]:
    """A text with damage, or facets with damaged bytes."""
    if draw.random() < 0.5:
        return _drawn(TEXT_STL, draw)
    content, what = damaged(BINARY_STL, draw)
    return content, [what]


def drawing(text: str) -> Callable[[random.Random], tuple[bytes, list[str]]]:
    """Return what damages one text."""
    return lambda draw: _drawn(text, draw)


def read_mesh(path: Path) -> Any:
    """Read a mesh and simplify it."""
    from amble.view.mesh_files import read_mesh as read
    from amble.view.meshes import simplified

    return simplified(0, read(path))
