"""Robots drawn with a seed: records and URDF files, sound before they are damaged."""

from __future__ import annotations

import random
from functools import cache
from importlib import resources
from xml.sax.saxutils import quoteattr

import numpy as np

from amble.robot import Foot, Joint, Link, Robot
from amble.types import frozen


@cache
def biped() -> Robot:
    """Two legs of a roll joint, a pitch joint and a knee: small, so that thousands can be drawn, and symmetric."""
    links = [Link("trunk", 8.0, frozen([0.0, 0.0, 0.05]), frozen(np.diag([0.06, 0.05, 0.04])))]
    joints, feet = [], []
    for label, side in (("l", 1.0), ("r", -1.0)):
        axes = (
            ("roll", (1.0, 0.0, 0.0), (0.0, 0.1 * side, -0.05)),
            ("pitch", (0.0, 1.0, 0.0), (0.0, 0.02 * side, 0.0)),
        )
        parent = 0
        for name, axis, at in (*axes, ("knee", (0.0, 1.0, 0.0), (0.0, 0.0, -0.25))):
            child = len(links)
            links.append(Link(f"{label}_{name}_link", 0.8, frozen([0.0, 0.01 * side, -0.1]), frozen(0.004 * np.eye(3))))
            joints.append(
                Joint(
                    name=f"{label}_{name}",
                    parent=parent,
                    child=child,
                    rotation=frozen(np.eye(3)),
                    translation=frozen(at),
                    axis=frozen(axis),
                    lower=-1.5,
                    upper=1.5,
                    effort=60.0,
                    velocity=float("inf") if name == "knee" else 8.0,
                )
            )
            parent = child
        feet.append(Foot(label, f"{label}_foot", parent, frozen([0.0, 0.0, -0.25])))
    return Robot(
        name="biped",
        source="biped.urdf",
        links=tuple(links),
        joints=tuple(joints),
        feet=tuple(feet),
        gravity=9.81,
        twins=(("l", "r"),),
    )


def urdf(draw: random.Random) -> str:
    """A tree of boxes: now and then a long chain, a massless root, or fixed, floating and other joints."""
    if draw.random() < 0.1:
        return (resources.files("amble.robot.catalogue") / "astro.urdf").read_text(encoding="utf-8")
    count = draw.choice((2, 3, 5, 9, 9, 9, 40)) if draw.random() < 0.99 else draw.choice((300, 3000))
    chain = draw.random() < 0.4
    lines = [f'<robot name="drawn{count}">']
    for number in range(count):
        lines.append(_link(number, draw))
    order = list(range(1, count))
    if draw.random() < 0.3:
        draw.shuffle(order)
    for number in order:
        parent = number - 1 if chain else draw.randrange(number)
        kind = draw.choices(("revolute", "continuous", "fixed", "prismatic"), (70, 20, 10, 0.2))[0]
        lines.append(
            f'<joint name="j{number}" type="{kind}"><parent link="l{parent}"/><child link="l{number}"/>'
            f'<origin xyz="0 {draw.choice((0, 0.1))} -0.2" rpy="0 0 {draw.choice((0, 0, 1.57))}"/>'
            f'<axis xyz="{draw.choice(("1 0 0", "0 1 0", "0 0.6 0.8"))}"/>'
            f'<limit lower="-1.5" upper="1.5" effort="60" velocity="8"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


def _link(number: int, draw: random.Random) -> str:
    if draw.random() < 0.05:
        return f'<link name="l{number}"/>'
    size = draw.uniform(0.005, 0.05)
    return (
        f'<link name="l{number}"><inertial><origin xyz="0 0 {draw.uniform(-0.1, 0.1):.3f}"/>'
        f'<mass value="{40 * size:.4g}"/>'
        f'<inertia ixx="{size:.4g}" ixy="0" ixz="0" iyy="{size:.4g}" iyz="0" izz="{size:.4g}"/></inertial></link>'
    )


ATTRIBUTES = (
    *("", " ", "0", "-1", "1e400", "-1e999", "nan", "inf", "6_0", "٣", "1 2", "1 2 3", "0 0 0", "1e308", "-1e-300"),
    *("nan nan nan", "9" * 5000, "1e308 1e308 1e308", "1e-320 0 0", "1e160 0 0", "a\tb", "x" * 5000, "1e155", "1e-160"),
    *(
        "fixed",
        "floating",
        "prismatic",
        "planar",
        "continuous",
        "revolute",
        "l0",
        "l1",
        "j1",
        "*/",
        "roll",
        "rate of x",
    ),
    *("a\nb", "\u202e", "world", "xacro:x", "1e150", "1e200", "-1e155", "5e-324"),
)
"""In the place of an attribute of a URDF."""

RAW = ("&#10;", "&amp;", "&#xD800;", "&bomb;", "&#0;", "<", '"', "\x00")
"""The same, unescaped."""


def quoted(value: str) -> str:
    """Write an attribute's value with its quotes."""
    return quoteattr(value)
