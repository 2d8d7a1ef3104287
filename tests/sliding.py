"""Robots with prismatic joints: random ones, with such joints at every place, and walkers on telescopic legs."""

from __future__ import annotations

from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from amble.robot import Robot, load_robot
from amble.types import Vector
from tests.quadruped import inertial

LABELS = ("fl", "fr", "rl", "rr")


def random_urdf(seed: int, prismatic: float = 0.5) -> str:
    """Four legs of two to four joints of random kinds, axes, frames and inertias.

    Args:
        seed: of everything.
        prismatic: share of joints that slide; at least one does, at the base, between two joints or before a foot.
    """
    draw = np.random.default_rng(seed)
    links, joints = [_link("base", draw)], list[str]()
    for number, label in enumerate(LABELS):
        parent, count = "base", int(draw.integers(2, 5))
        slides = draw.random(count) < prismatic
        slides[number % count] = True
        for place in range(count):
            name, kind = f"{label}_{place}", "prismatic" if slides[place] else "revolute"
            links.append(_link(name, draw))
            joints.append(
                f'<joint name="{name}_joint" type="{kind}"><parent link="{parent}"/><child link="{name}"/>'
                f'<origin xyz="{_three(0.3 * draw.normal(size=3))}" rpy="{_three(draw.normal(size=3))}"/>'
                f'<axis xyz="{_three(draw.normal(size=3))}"/>'
                '<limit lower="-0.2" upper="0.3" effort="80" velocity="4"/></joint>'
            )
            parent = name
        links.append(f'<link name="{label}_foot"/>')
        joints.append(
            f'<joint name="{label}_end" type="fixed"><parent link="{parent}"/><child link="{label}_foot"/>'
            f'<origin xyz="{_three(0.2 * draw.normal(size=3))}"/></joint>'
        )
    return f'<robot name="sliding{seed}">' + "".join(links + joints) + "</robot>"


def sliding(seed: int) -> Robot:
    """The robot of ``random_urdf``."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "robot.urdf"
        file.write_text(random_urdf(seed))
        return load_robot(file, {label: f"{label}_foot" for label in LABELS}, twins=())


def _link(name: str, draw: np.random.Generator) -> str:
    root = draw.normal(size=(3, 3))
    tensor = 0.01 * (root @ root.T + 0.5 * np.eye(3))
    entries = {"ixx": (0, 0), "ixy": (0, 1), "ixz": (0, 2), "iyy": (1, 1), "iyz": (1, 2), "izz": (2, 2)}
    moments = " ".join(f'{key}="{tensor[place]:.17g}"' for key, place in entries.items())
    return (
        f'<link name="{name}"><inertial><origin xyz="{_three(0.1 * draw.normal(size=3))}" '
        f'rpy="{_three(draw.normal(size=3))}"/><mass value="{draw.uniform(0.2, 3.0):.17g}"/>'
        f"<inertia {moments}/></inertial></link>"
    )


def _three(values: Vector) -> str:
    return " ".join(f"{value:.17g}" for value in values)


SHANK = "0 0.16 150 2"
"""Lower, upper, effort and velocity of what slides."""

HIPS = {"fl": (0.19, 0.1), "fr": (0.19, -0.1), "rl": (-0.19, 0.1), "rr": (-0.19, -0.1)}


def telescopic_urdf() -> str:
    """A quadruped of 9 kg: hip roll, hip pitch and a shank that slides out of the thigh, legs of 0.28 to 0.44 m."""
    parts = ['<link name="trunk">' + inertial(6.0, "0 0 0", "0.04 0.09 0.11") + "</link>"]
    for leg, (x, y) in HIPS.items():
        out = 0.05 if y > 0.0 else -0.05
        parts += [
            f'<link name="{leg}_hip">{inertial(0.3, f"0 {0.4 * out} 0", "2e-4 2e-4 2e-4")}</link>',
            f'<link name="{leg}_thigh">{inertial(0.4, "0 0 -0.1", "1.5e-3 1.5e-3 1e-4")}</link>',
            f'<link name="{leg}_shank">{inertial(0.12, "0 0 -0.1", "4e-4 4e-4 1e-5")}</link><link name="{leg}_foot"/>',
            limited(f"{leg}_roll", "revolute", ("trunk", f"{leg}_hip"), f"{x} {y} 0", "1 0 0", "-0.3 0.3 25 20"),
            limited(f"{leg}_pitch", "revolute", (f"{leg}_hip", f"{leg}_thigh"), f"0 {out} 0", "0 1 0", "-0.7 0.7 25 9"),
            limited(f"{leg}_slide", "prismatic", (f"{leg}_thigh", f"{leg}_shank"), "0 0 -0.1", "0 0 -1", SHANK),
            f'<joint name="{leg}_end" type="fixed"><parent link="{leg}_shank"/><child link="{leg}_foot"/>'
            '<origin xyz="0 0 -0.18"/></joint>',
        ]
    return f'<robot name="telescopic">{"".join(parts)}</robot>'


def limited(name: str, kind: str, links: tuple[str, str], at: str, axis: str, limits: str) -> str:
    """A joint with its limits: lower, upper, effort, velocity."""
    lower, upper, effort, velocity = limits.split()
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{links[0]}"/><child link="{links[1]}"/><origin xyz="{at}"/>'
        f'<axis xyz="{axis}"/>'
        f'<limit lower="{lower}" upper="{upper}" effort="{effort}" velocity="{velocity}"/></joint>'
    )


FEET = {label: f"{label}_foot" for label in LABELS}


@lru_cache(maxsize=1)
def telescopic() -> Robot:
    """The robot of ``telescopic_urdf``."""
    with TemporaryDirectory() as folder:
        file = Path(folder) / "telescopic.urdf"
        file.write_text(telescopic_urdf())
        return load_robot(file, FEET)
