"""A robot format of one's own: links and joints as a TOML file of plain numbers. One function, one registration.

name = "leg"

[links.trunk]
mass = 4.0                        # kg
center = [0.0, 0.0, 0.0]          # m
inertia = [0.02, 0.03, 0.04]      # principal moments about the link's axes, kg m^2

[joints.hip]
parent = "trunk"
child = "thigh"
at = [0.1, 0.0, 0.0]              # m, in the parent's axes; the child's axes are parallel where it stands at zero
axis = [0.0, 1.0, 0.0]            # without an axis the joint is fixed
range = [-1.0, 1.0]               # rad
torque = 20.0                     # N m
speed = 12.0                      # rad/s
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from math import inf
from pathlib import Path
from typing import Any

import numpy as np

from amble.errors import InputError, UnknownNameError, shown
from amble.io.reader import read_toml
from amble.robot import READERS
from amble.robot.readers import FileJoint, FileLink, FileRobot
from amble.types import Vector, frozen

LINK = ("mass", "center", "inertia")
JOINT = ("parent", "child", "at", "axis", "range", "torque", "speed")


def read_robot_toml(path: Path) -> FileRobot:
    """Read the file as written; merging, feet and physics are checked by ``load_robot``, whatever the format.

    Raises:
        InputError: the file cannot be read, a key is unknown or missing, or a value is not numbers.
    """
    tree = read_toml(path, "robot file")
    _known(path.name, tree, ("name", "links", "joints"))
    links = [_link(f"{path.name}, link '{shown(name)}'", name, one) for name, one in _table(path, tree, "links")]
    joints = [_joint(f"{path.name}, joint '{shown(name)}'", name, one) for name, one in _table(path, tree, "joints")]
    return FileRobot(str(tree.get("name", path.stem)), tuple(links), tuple(joints))


def _table(path: Path, tree: Mapping[str, Any], key: str) -> Iterable[tuple[str, Mapping[str, Any]]]:
    table = tree.get(key, {})
    if not (isinstance(table, dict) and all(isinstance(one, dict) for one in table.values())):
        raise InputError(f"{path.name}: '{key}' is not a table of tables")
    return table.items()


def _link(place: str, name: str, given: Mapping[str, Any]) -> FileLink:
    _known(place, given, LINK)
    mass, center, moments = (
        _numbers(place, given, key, size, [0.0] * size) for key, size in zip(LINK, (1, 3, 3), strict=True)
    )
    return FileLink(name, float(mass[0]), center, frozen(np.diag(moments)))


def _joint(place: str, name: str, given: Mapping[str, Any]) -> FileJoint:
    _known(place, given, JOINT)
    for key in ("parent", "child"):
        if not isinstance(given.get(key), str):
            raise InputError(f"{place}: '{key}' is not the name of a link")
    lower, upper = _numbers(place, given, "range", 2, [-inf, inf])
    axis = _numbers(place, given, "axis", 3, [1.0, 0.0, 0.0])
    length = float(np.linalg.norm(axis))
    if length == 0.0:
        raise InputError(f"{place} has an axis of length zero")
    return FileJoint(
        name=name,
        kind="revolute" if "axis" in given else "fixed",
        parent=given["parent"],
        child=given["child"],
        rotation=frozen(np.eye(3)),
        translation=_numbers(place, given, "at", 3, [0.0] * 3),
        axis=frozen(axis / length),
        lower=float(lower),
        upper=float(upper),
        effort=float(_numbers(place, given, "torque", 1, [inf])[0]),
        velocity=float(_numbers(place, given, "speed", 1, [inf])[0]),
        mimics=None,
    )


def _known(place: str, given: Mapping[str, Any], keys: tuple[str, ...]) -> None:
    for key in given:
        if key not in keys:
            raise UnknownNameError(f"key of {place}", key, keys)


def _numbers(place: str, given: Mapping[str, Any], key: str, size: int, default: list[float]) -> Vector:
    values = given.get(key, default)
    values = values if isinstance(values, list) else [values]
    if len(values) != size or not all(type(value) in (int, float) for value in values):
        raise InputError(f"{place}: '{key}' is not {size} number{'s' if size > 1 else ''}")
    return frozen(np.array(values, dtype=np.float64))


READERS.register("toml", read_robot_toml)
