"""Triangles of mesh files: STL (binary and text), OBJ, Collada; textures, normals and colours are left out."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator, Mapping
from functools import cache
from itertools import islice
from pathlib import Path
from xml.etree import ElementTree

import numpy as np

from amble.amounts import LARGEST_NUMBER
from amble.errors import InputError, shown, shown_path
from amble.io.reader import read_bytes
from amble.io.xml import parse_xml
from amble.types import IntegerVector, Matrix, NodeValues

LARGEST, LARGEST_TEXT = 64 * 2**20, 16 * 2**20
"""Bytes of a mesh file in binary, and in text, whose words take many times their size."""

DEEPEST = 50
"""Nodes inside each other."""

MOST_TRIANGLES = 1_500_000
"""Of a file: one of 1 KB can place a mesh a million times, and a polygon has a triangle for every two bytes."""

MOST_NODES, MOST_PARTS = 100_000, 50_000
"""Elements of a scene that are walked, instances as often as they are placed; lists of corners of all meshes."""

HEADER, FACET = 84, 50
"""Bytes of a binary STL file before its facets, and of each facet."""


def read_mesh(path: Path) -> NodeValues:
    """Return the triangles of a mesh file, (n, 3, 3), in the file's axes and unit (Collada: z up, m).

    Raises:
        InputError: the file cannot be read, is of an unknown format, or holds no triangle of finite numbers.
    """
    name = f"mesh file '{shown_path(path)}'"
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(f"{name} is of no known format; known: {', '.join(READERS)}")
    content = read_bytes(path, "mesh file", LARGEST)
    try:
        with np.errstate(all="ignore"):  # what overflows is refused below
            triangles = np.asarray(reader(content), dtype=np.float64)
    except (ValueError, LookupError, OverflowError, struct.error, ElementTree.ParseError) as error:
        raise InputError(f"{name} cannot be read: {shown(str(error))}") from error
    if triangles.size == 0 or not np.all(np.abs(triangles) <= LARGEST_NUMBER):
        raise InputError(f"{name} holds no triangles, or numbers that are not finite or above {LARGEST_NUMBER:g}")
    return triangles


def _stl(content: bytes) -> NodeValues:
    count = struct.unpack_from("<I", content, HEADER - 4)[0] if len(content) >= HEADER else 0
    if len(content) == HEADER + FACET * count:
        facets = np.frombuffer(content, dtype=np.uint8, offset=HEADER).reshape(count, FACET)
        return facets[:, 12:48].copy().view("<f4").reshape(count, 3, 3).astype(np.float64)
    words = _text(content).split()
    places = [index for index, word in enumerate(words) if word == "vertex"]
    return np.array([[float(word) for word in words[k + 1 : k + 4]] for k in places]).reshape(-1, 3, 3)


def _obj(content: bytes) -> NodeValues:
    vertices: list[list[float]] = []
    found: list[tuple[int, int, int]] = []
    for line in _text(content).splitlines():
        key, *words = line.split() or [""]
        if key == "v":
            vertices.append([float(word) for word in words[:3]])
        elif key == "f":
            corners = [int(word.partition("/")[0]) for word in words]
            corners = [corner - 1 if corner > 0 else len(vertices) + corner for corner in corners]
            _check_count(len(found) + len(corners))
            found += [(corners[0], corners[k], corners[k + 1]) for k in range(1, len(corners) - 1)]
    return np.array(vertices)[np.array(found, dtype=np.int64)]


def _collada(content: bytes) -> NodeValues:
    root = parse_xml(content if len(content) <= LARGEST_TEXT else _text(content))
    for element in root.iter():
        element.tag = str(element.tag).rpartition("}")[2]
    known = {element.get("id", ""): element for element in root.iter() if element.get("id")}
    unit = root.find("asset/unit")
    scale = 1.0 if unit is None else float(unit.get("meter", "1"))
    meshes = _geometries(root, known)
    scene = root.find("library_visual_scenes")
    placed = [] if scene is None else list(islice(_instances(scene, np.eye(4), known), MOST_NODES + 1))
    if len(placed) > MOST_NODES:
        raise ValueError(f"its scene has more than {MOST_NODES} elements")
    _check_count(sum(len(meshes.get(url, ())) for url, _ in placed))
    parts = [meshes[url] @ turn[:3, :3].T + turn[:3, 3] for url, turn in placed if url in meshes]
    triangles = scale * np.concatenate([*(parts or meshes.values()), np.zeros((0, 3, 3))])
    axis = root.findtext("asset/up_axis", "Y_UP").strip()
    order, signs = {"Z_UP": ((0, 1, 2), (1, 1, 1)), "X_UP": ((1, 2, 0), (1, 1, 1))}.get(axis, ((0, 2, 1), (1, -1, 1)))
    return np.asarray(triangles[..., list(order)] * signs)


def _text(content: bytes) -> str:
    if len(content) > LARGEST_TEXT:
        raise ValueError(f"it is text of more than {LARGEST_TEXT / 2**20:g} MB")
    return content.decode("utf-8", "replace")


def _check_count(triangles: int) -> None:
    if triangles > MOST_TRIANGLES:
        raise ValueError(f"it has more than {MOST_TRIANGLES} triangles")


def _geometries(root: ElementTree.Element, known: Mapping[str, ElementTree.Element]) -> dict[str, NodeValues]:
    """Return the address of every mesh of a Collada file -> its triangles."""
    points = cache(lambda source: _points(known[source]))  # many parts may share what takes long to read
    found: dict[str, list[NodeValues]] = {}
    parts = triangles = 0
    for geometry in root.iterfind("library_geometries/geometry"):
        own = found.setdefault(f"#{geometry.get('id')}", [np.zeros((0, 3, 3))])
        for part in _primitives(geometry, known, points):
            parts, triangles = parts + 1, triangles + len(part)
            _check_count(triangles)
            if parts > MOST_PARTS:
                raise ValueError(f"its meshes have more than {MOST_PARTS} lists of corners")
            own.append(part)
    return {address: np.concatenate(own) for address, own in found.items()}


def _points(source: ElementTree.Element) -> Matrix:
    return np.array(source.findtext("float_array", "").split(), dtype=np.float64).reshape(-1, 3)


def _instances(
    node: ElementTree.Element, turn: Matrix, known: Mapping[str, ElementTree.Element], depth: int = 0
) -> Iterator[tuple[str, Matrix]]:
    """Yield the geometries below a node of a scene, with what they are transformed by, and "" for all other elements.

    So whoever counts what is yielded bounds the work too: nodes that place each other twice are walked 2^n times.
    """
    if depth > DEEPEST:
        raise ValueError(f"its scene is nested more than {DEEPEST} times")
    for child in node:
        numbers = [float(word) for word in (child.text or "").split()] if child.tag in TRANSFORMS else []
        yield "", turn
        if numbers:
            turn = turn @ TRANSFORMS[child.tag](np.array(numbers))
        elif child.tag == "instance_geometry":
            yield child.get("url", ""), turn
        elif child.tag == "instance_node":
            yield from _instances(known[child.get("url", "")[1:]], turn, known, depth + 1)
        elif child.tag in ("node", "visual_scene"):
            yield from _instances(child, turn, known, depth + 1)


def _affine(linear: Matrix, shift: Matrix) -> Matrix:
    whole = np.eye(4)
    whole[:3, :3], whole[:3, 3] = linear, shift
    return whole


def _rotation(numbers: Matrix) -> Matrix:
    from scipy.spatial.transform import Rotation

    turn = Rotation.from_rotvec(np.radians(numbers[3]) * numbers[:3] / np.linalg.norm(numbers[:3]))
    return _affine(turn.as_matrix(), np.zeros(3))


TRANSFORMS: Mapping[str, Callable[[Matrix], Matrix]] = {
    "matrix": lambda numbers: numbers.reshape(4, 4),
    "translate": lambda numbers: _affine(np.eye(3), numbers),
    "scale": lambda numbers: _affine(np.diag(numbers), np.zeros(3)),
    "rotate": _rotation,
}
"""Elements that move what follows them in a node of a Collada scene."""


def _primitives(
    geometry: ElementTree.Element, known: Mapping[str, ElementTree.Element], points: Callable[[str], Matrix]
) -> Iterator[NodeValues]:
    for part in (*geometry.iter("triangles"), *geometry.iter("polylist"), *geometry.iter("polygons")):
        inputs = {entry.get("semantic"): entry for entry in part.findall("input")}
        vertex = inputs["VERTEX"]
        sources = {entry.get("semantic"): entry.get("source", "") for entry in known[vertex.get("source", "")[1:]]}
        places = points(sources["POSITION"][1:])
        stride = 1 + max(int(entry.get("offset", "0")) for entry in part.findall("input"))
        for numbers in part.findall("p"):
            rows = np.array((numbers.text or "").split(), dtype=np.int64).reshape(-1, stride)
            corners = rows[:, int(vertex.get("offset", "0"))]
            counts = _counts(part, len(corners))
            if np.any(counts < 3) or np.any(counts > len(corners)) or counts.sum() != len(corners):
                raise ValueError("corners of its faces do not add up")
            starts = np.repeat(np.cumsum(counts) - counts, counts - 2)
            within = np.concatenate([np.arange(1, count - 1) for count in counts] or [np.zeros(0, dtype=np.int64)])
            yield places[corners[np.column_stack([starts, starts + within, starts + within + 1])]]


def _counts(part: ElementTree.Element, corners: int) -> IntegerVector:
    """Corners of every face of a primitive."""
    if part.tag == "triangles":
        return np.full(corners // 3, 3)
    if part.tag == "polygons":
        return np.array([corners])
    return np.array(part.findtext("vcount", "").split(), dtype=np.int64)


READERS: Mapping[str, Callable[[bytes], NodeValues]] = {".stl": _stl, ".obj": _obj, ".dae": _collada}
