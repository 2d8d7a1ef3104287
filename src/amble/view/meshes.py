"""What the links of a robot look like in its URDF file: meshes and primitives, as few triangles a link.

The record of a robot holds no looks, so they come from the file when it is named; its links have to be the record's.
"""

from __future__ import annotations

import logging
import os
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from urllib.parse import unquote, urlsplit
from xml.etree import ElementTree

import numpy as np

from amble.errors import InputError, printable, shown
from amble.robot import Robot
from amble.robot.adaptation import Adaptation
from amble.robot.loading import placed_links
from amble.robot.urdf import attribute, number, origin_of, parsed_urdf, read_urdf, triple
from amble.types import IntegerVector, Matrix, NodeValues
from amble.view.mesh_files import read_mesh

logger = logging.getLogger("amble")

MOST = 450
"""Triangles of a link, at most: what a canvas draws in time for thirteen of them."""

LATTICES = tuple(2048.0 * 0.8**step for step in range(33))
"""Cells along the longest side of a link, from fine to coarse."""

MOST_OF_ROBOT = 5_000_000
"""Triangles of all looks of a file, before they are joined."""

SIDES = 16
"""Of a cylinder, and around a sphere."""

SAME = 0.02
"""How far a joint of the file may be from the record's, as a share of the leg length: symmetrised robots differ."""


@dataclass(frozen=True, kw_only=True)
class Mesh:
    """What a link looks like.

    Attributes:
        link: index of the link.
        vertices: in the link's frame, (n, 3), m.
        faces: rows of three vertices, (m, 3).
    """

    link: int
    vertices: Matrix
    faces: IntegerVector


def link_meshes(robot: Robot, path: str | Path) -> tuple[Mesh, ...]:
    """Read the looks of a robot's links from its URDF file; links without any are left out, with a notice.

    Args:
        robot: as it was loaded from the file, also with joints locked.
        path: the file; ``package://`` addresses are looked for in the folders above it.

    Raises:
        InputError: the file is no URDF, or not of this robot.
    """
    path = Path(path)
    file, root = read_urdf(path), parsed_urdf(path)
    names = [link.name for link in robot.links]
    if names[0] not in {link.name for link in file.links}:
        raise InputError(f"{path.name}: there is no link '{names[0]}', the base of robot '{robot.name}'")
    places = placed_links(file, path, Adaptation(base=names[0], locked=robot.locked_joints))
    _check_same(robot, {joint.name: (joint.parent, joint.translation) for joint in file.joints}, places, path)
    found: dict[int, list[NodeValues]] = {}
    lost: list[str] = []
    read, count = cache(read_mesh), 0  # four legs share their files
    for element in root.findall("link"):
        link = element.get("name", "")
        if link not in places or places[link][0] not in names:
            continue
        carrier, rotation, translation = places[link]
        for triangles in _visuals(element, path, lost, read):
            count += len(triangles)
            if count > MOST_OF_ROBOT:
                raise InputError(
                    f"{path.name}: its looks have more than {MOST_OF_ROBOT} triangles; simplify its meshes"
                )
            found.setdefault(names.index(carrier), []).append(triangles @ rotation.T + translation)
    if lost:
        few = "; ".join(dict.fromkeys(lost[:3]))
        logger.warning("%s: %d looks are left out: %s", path.name, len(lost), printable(few))
    return tuple(simplified(link, np.concatenate(parts)) for link, parts in sorted(found.items()))


def _check_same(
    robot: Robot,
    joints: dict[str, tuple[str, Matrix]],
    places: dict[str, tuple[str, Matrix, Matrix]],
    path: Path,
) -> None:
    for joint in robot.joints:
        parent, origin = joints.get(joint.name, ("", np.zeros(3)))
        carrier, rotation, translation = places.get(parent, ("", np.eye(3), np.zeros(3)))
        away = np.linalg.norm(translation + rotation @ origin - joint.translation)
        if carrier != robot.links[joint.parent].name or away > SAME * robot.leg_length:
            raise InputError(f"{path.name} is not the file of robot '{robot.name}': joint '{joint.name}' is elsewhere")


def _visuals(
    link: ElementTree.Element, path: Path, lost: list[str], read: Callable[[Path], NodeValues]
) -> Iterator[NodeValues]:
    """Yield the triangles of a link's visual elements, in its axes; what cannot be read is added to ``lost``."""
    for visual in link.findall("visual"):
        where = f"{path.name}: a visual element of link '{shown(link.get('name', ''))}'"
        rotation, translation = origin_of(visual, where)
        for shape in visual.iterfind("geometry/*"):
            try:
                yield _triangles(shape, path, where, read) @ rotation.T + translation
            except InputError as error:
                lost.append(str(error))


def _triangles(shape: ElementTree.Element, path: Path, where: str, read: Callable[[Path], NodeValues]) -> NodeValues:
    if shape.tag == "mesh":
        scale = triple(shape.get("scale", "1 1 1"), f"{where}, scale")
        return read(_resolved(attribute(shape, "filename", where), path)) * scale
    if shape.tag == "box":
        return _lathe(np.array([[0.0, -0.5], [np.sqrt(0.5), -0.5], [np.sqrt(0.5), 0.5], [0.0, 0.5]]), 4) * triple(
            attribute(shape, "size", where), f"{where}, size"
        )
    if shape.tag not in ("cylinder", "sphere"):
        raise InputError(f"{where} is a '{shown(str(shape.tag))}'; known: mesh, box, cylinder, sphere")
    radius = number(attribute(shape, "radius", where), f"{where}, radius")
    if shape.tag == "sphere":
        angles = np.linspace(-0.5 * np.pi, 0.5 * np.pi, SIDES // 2 + 1)
        return _lathe(radius * np.column_stack([np.cos(angles), np.sin(angles)]), SIDES)
    half = 0.5 * number(attribute(shape, "length", where), f"{where}, length")
    return _lathe(np.array([[0.0, -half], [radius, -half], [radius, half], [0.0, half]]), SIDES)


def _lathe(profile: Matrix, sides: int) -> NodeValues:
    """Turn a profile of radius and height about z; corners stand at odd multiples of half a side."""
    angles = 2.0 * np.pi * (np.arange(sides + 1) + 0.5) / sides
    ring = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    points = np.concatenate(
        [profile[:, None, :1] * ring, np.broadcast_to(profile[:, None, 1:], (len(profile), sides + 1, 1))], axis=-1
    )
    a, b, c, d = points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]
    return np.concatenate([np.stack(corners, axis=-2).reshape(-1, 3, 3) for corners in ((a, b, c), (a, c, d))])


def _resolved(address: str, path: Path) -> Path:
    """Find the file of a mesh: beside the URDF, or of a package in one of the folders above it."""
    try:
        parts = urlsplit(address)
    except ValueError as error:  # of a host in half a bracket
        raise InputError(f"'{shown(address)}' is no address: {shown(str(error))}") from None
    if parts.scheme == "file":
        return Path(unquote(parts.path))
    if parts.scheme != "package":
        return path.parent / address
    package, rest = parts.netloc, unquote(parts.path).lstrip("/")
    for folder in Path(os.path.realpath(path)).parents:
        for place in (folder / package / rest, folder / rest) if folder.name == package else (folder / package / rest,):
            if os.path.isfile(place):
                return place
    raise InputError(f"'{shown(address)}' was not found above {path.name}")


def simplified(link: int, triangles: NodeValues) -> Mesh:
    """Join corners that lie in one cell of a lattice, which is made coarser until few faces are left.

    Args:
        link: index of the link.
        triangles: (n, 3, 3), m.
    """
    points = triangles.reshape(-1, 3)
    low, size = points.min(axis=0), float(np.ptp(points, axis=0).max()) or 1.0
    places = (points - low) / size
    fine, coarse = 0, len(LATTICES) - 1
    while fine < coarse:  # the finest lattice that leaves few faces; the coarsest whatever it leaves
        middle = (fine + coarse) // 2
        few = len(_joined(places, LATTICES[middle])[1]) <= MOST
        fine, coarse = (fine, middle) if few else (middle + 1, coarse)
    inverse, faces = _joined(places, LATTICES[fine])
    keys = int(inverse.max()) + 1
    counts = np.bincount(inverse, minlength=keys)
    vertices = np.column_stack([np.bincount(inverse, weights=points[:, k], minlength=keys) for k in range(3)])
    return Mesh(link=link, vertices=vertices / counts[:, None], faces=faces)


def _joined(places: Matrix, cells: float) -> tuple[IntegerVector, IntegerVector]:
    """Return which vertex every corner becomes, and the faces that are left, each once, in their order.

    Args:
        places: of the corners, three a triangle, from 0 to 1, (3 n, 3).
        cells: of the lattice along its longest side, up to 2048.
    """
    cell = np.floor(places * cells).astype(np.int64)
    keys = (cell[:, 0] * 4096 + cell[:, 1]) * 4096 + cell[:, 2]
    inverse = np.unique(keys, return_inverse=True)[1].ravel()
    faces = inverse.reshape(-1, 3)
    faces = faces[(faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 0] != faces[:, 2])]
    ordered, count = np.sort(faces, axis=1), int(inverse.max()) + 1
    pairs = np.unique(ordered[:, 0] * count + ordered[:, 1], return_inverse=True)[1].ravel()
    first = np.unique(pairs * count + ordered[:, 2], return_index=True)[1]
    return inverse, faces[np.sort(first)]
