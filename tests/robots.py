"""Robots for tests: the catalogue's, and real ones from the wheel example-robot-data (a test extra)."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from functools import lru_cache
from importlib import resources
from pathlib import Path

import numpy as np
import pytest
from _pytest.mark import ParameterSet

from amble.robot import Adaptation, Robot, catalogue, load_robot
from amble.types import Matrix
from benchmarks.robot_files import FILES

CATALOGUE = ("astro", "astro_cad")
EXACTLY_SYMMETRIC = CATALOGUE


_FILES = {name: FILES[name] for name in ("solo12", "go2", "anymal_b")}
PLANAR = "planar_biped"
NAMES = (*CATALOGUE, *_FILES)

# Symmetric to 1.5e-4 (Solo12), 8.5e-4 (Go2) and 6.6e-3 (ANYmal B) of their inertias, measured by the mirror itself.
SYMMETRY_TOLERANCE = 1e-2


def _parameter(name: str) -> object:
    absent = _FILES[name].absent if name in _FILES else ""
    return pytest.param(name, marks=pytest.mark.skipif(bool(absent), reason=absent))


ROBOTS = [_parameter(name) for name in NAMES]
"""Parameters for ``pytest.mark.parametrize("name", ROBOTS)``: quadrupeds in space."""

EVERY_BASE = [*ROBOTS, PLANAR]
"""The same and a biped in the plane."""


def _foreign(names: Iterable[str]) -> list[ParameterSet]:
    marks = {name: pytest.mark.skipif(bool(FILES[name].absent), reason=FILES[name].absent) for name in names}
    return [pytest.param(name, marks=[pytest.mark.slow, mark]) for name, mark in marks.items()]


FOREIGN_QUADRUPEDS = _foreign(
    name for name, file in FILES.items() if len(file.frames) == 4 and name not in (*_FILES, "mini_cheetah")
)
"""The rest of the fleet's quadrupeds, for `make slow`; Mini Cheetah's file has joints of the base, Pinocchio's too."""

FOREIGN = [*FOREIGN_QUADRUPEDS, *_foreign(["bolt"])]
"""The same and a biped."""


def path(name: str) -> Path:
    """The URDF file of a robot."""
    if name in CATALOGUE:
        return Path(str(resources.files("amble.robot.catalogue") / f"{name}.urdf"))
    if name == PLANAR:
        return Path(__file__).parent / "data" / "planar-biped.urdf"
    if FILES[name].absent:
        pytest.skip(FILES[name].absent)
    return FILES[name].place()


@lru_cache(maxsize=16)
def robot(name: str) -> Robot:
    """A robot by its name in ``NAMES``, or the planar biped."""
    if name in CATALOGUE:
        return catalogue.load(name)
    if name == PLANAR:
        return load_robot(path(name), {"l": "l_foot", "r": "r_foot"}, twins=[("l", "r")], name=name)
    if name in _FILES:
        return load_robot(path(name), _FILES[name].feet, name=name, symmetry_tolerance=SYMMETRY_TOLERANCE)
    bare = Adaptation(file_drives=False)  # Pinocchio takes no damping and dry friction of a file
    return load_robot(path(name), FILES[name].feet, name=name, symmetry_tolerance=1.0, adaptation=bare)


def random_states(of: Robot, count: int, seed: int = 0) -> tuple[Matrix, Matrix]:
    """Coordinates and velocities, (count, n_q) each: angles over a full turn, but pitch at most 1.2 rad."""
    generator = np.random.default_rng(seed)
    q = generator.uniform(-np.pi, np.pi, (count, of.size))
    q[:, of.coordinate_index("pitch")] *= 1.2 / np.pi
    return q, generator.normal(0.0, 2.0, (count, of.size))


@lru_cache(maxsize=1)
def hexapod() -> Robot:
    """ASTRo with a third pair of legs: copies of its front legs at the middle of the base."""
    astro = robot("astro")
    links, joints, feet = list(astro.links), list(astro.joints), list(astro.feet)
    for name, label in (("fl", "ml"), ("fr", "mr")):
        parent = 0
        for j in astro.chain(astro.foot(name).link):
            at = astro.joints[j].translation * ([0.0, 1.0, 1.0] if parent == 0 else [1.0, 1.0, 1.0])
            links.append(replace(astro.links[j + 1], name=f"middle {astro.links[j + 1].name}"))
            joints.append(
                replace(
                    astro.joints[j],
                    name=astro.joints[j].name.replace(name, label),
                    parent=parent,
                    child=len(links) - 1,
                    translation=at,
                )
            )
            parent = len(links) - 1
        feet.append(replace(astro.foot(name), name=label, link=parent))
    return replace(astro, name="hexapod", links=tuple(links), joints=tuple(joints), feet=tuple(feet), twins=())
