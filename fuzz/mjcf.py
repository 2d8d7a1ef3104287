"""MJCF files with damage: a real robot's or a small one's attributes, elements and bytes, bombs, and other files."""

from __future__ import annotations

import logging
import random
import re
from functools import cache
from pathlib import Path
from typing import Any

from fuzz.bytes import damaged
from fuzz.robots import ATTRIBUTES, RAW, biped, quoted
from fuzz.words import NAMES

VALUES = (
    *("1e308 1e308 1e308", "nan", "-1", "0", "9" * 400, "mesh", "free", "ball", "hfield", "sdf", "true", "auto"),
    *("0 0 0 0", "1 0 0 0", "trunk", "1e-320", "2147483648", "-2147483649", "l_knee", "main", "motor", "0 0 0 1e300"),
)  # fmt: skip

BODY = '<body><freejoint/><geom size="0.1"/></body>'

INSERTED = (
    '<include file="/etc/passwd"/>',
    '<include file="input.xml"/>',
    '<include file="../input.xml"/>',
    '<asset><model name="m" file="/dev/zero"/></asset>',
    '<asset><mesh name="m" file="/etc/hostname"/></asset>',
    '<asset><mesh name="m" file="/dev/zero.obj"/></asset><worldbody><body><freejoint/><geom type="mesh" mesh="m"/>'
    "</body></worldbody>",
    '<asset><hfield name="h" nrow="2000000000" ncol="2000000000" size="1 1 1 1"/></asset>',
    '<asset><hfield name="h" file="/etc/passwd" size="1 1 1 1"/></asset>',
    '<asset><texture name="t" type="2d" builtin="checker" width="1000000" height="1000000"/></asset>',
    '<asset><skin name="s" file="/etc/passwd"/></asset>',
    '<size memory="900G"/>',
    '<size nuserdata="2000000000"/>',
    f'<worldbody><replicate count="2000000000" offset="0 0 1">{BODY}</replicate></worldbody>',
    f'<worldbody><replicate count="300" offset="0 0 1">{BODY}</replicate></worldbody>',
    '<worldbody><composite type="cable" count="1000 1000 1000" size="1"><geom size="1"/></composite></worldbody>',
    '<worldbody><flexcomp name="f" type="grid" count="1000 1000 1000" spacing="1 1 1"/></worldbody>',
    '<extension><plugin plugin="mujoco.elasticity.cable"/></extension>',
    '<option timestep="-1" integrator="implicit"/>',
    '<compiler discardvisual="true" fusestatic="true" balanceinertia="true" inertiafromgeom="true"/>',
    '<keyframe><key qpos="1 2"/></keyframe>',
    '<tendon><spatial name="t" springlength="1"><site site="l_foot"/><site site="r_foot"/></spatial></tendon>',
    '<equality><joint joint1="l_knee" joint2="r_knee" polycoef="0 1 0 0 0"/></equality>',
    '<custom><numeric name="a" size="2000000000" data="1"/></custom>',
)  # fmt: skip
"""In the place of nothing: what reads other files, multiplies, or is seldom used."""

HEADS = (
    *("\ufeff", "<!-- -->", '<?xml version="1.0" encoding="utf-16"?>', "\x00", "<mujoco>" * 5000),
    '<!DOCTYPE a [<!ENTITY a "aaaaaaaaaa"><!ENTITY b "&a;&a;&a;&a;&a;&a;"><!ENTITY c "&b;&b;&b;&b;&b;&b;">]>',
    '<!DOCTYPE a [<!ENTITY c SYSTEM "file:///etc/passwd">]>',
)

_ATTRIBUTE = re.compile(r'(?<=[a-z0-9])="([^"<>]*)"')
_ELEMENT = re.compile(r"<(\w+)[^<>]*/>|<(body|default|actuator)\b.*?</\2>", re.DOTALL)


@cache
def small() -> str:
    """The biped as MJCF, with what a real file has: classes, motors, sites, a floor, a mesh that only looks."""
    robot = biped()
    at = {joint.child: joint for joint in robot.joints}

    def body(link: int) -> str:
        joint, here = at.get(link), robot.links[link]
        place = "0 0 1" if joint is None else " ".join(map(str, joint.translation))
        inertia = " ".join(str(here.inertia[i, i]) for i in range(3))
        lines = [f'<body name="{here.name}" pos="{place}">']
        lines.append("<freejoint/>" if joint is None else _joint(joint.name, joint.axis))
        centre = " ".join(map(str, here.center))
        lines.append(f'<inertial pos="{centre}" mass="{here.mass}" diaginertia="{inertia}"/>')
        lines.append('<geom type="capsule" size="0.02" fromto="0 0 0 0 0 -0.2"/><geom type="mesh" mesh="looks"/>')
        lines += [
            f'<site name="{foot.frame}" pos="{" ".join(map(str, foot.offset))}"/>'
            for foot in robot.feet
            if foot.link == link
        ]
        lines += [body(child) for child, above in at.items() if above.parent == link]
        return "".join([*lines, "</body>"])

    motors = "".join(f'<motor joint="{joint.name}" gear="2" ctrlrange="-30 30"/>' for joint in robot.joints)
    return (
        '<mujoco model="biped"><compiler angle="radian" meshdir="assets"/><option gravity="0 0 -9.81"/>'
        '<default><joint armature="0.01" damping="0.2"/><default class="knee"><joint damping="1"/></default></default>'
        '<asset><mesh name="looks" file="looks.stl"/></asset>'
        f'<worldbody><geom type="plane" size="9 9 1"/>{body(0)}</worldbody><actuator>{motors}</actuator></mujoco>'
    )


def _joint(name: str, axis: Any) -> str:
    kind = ' class="knee"' if name.endswith("knee") else ""
    return f'<joint name="{name}" axis="{" ".join(map(str, axis))}" range="-1.5 1.5"{kind}/>'


@cache
def real() -> str:
    """Go2 as its makers publish it; the biped where the wheel is not installed."""
    from benchmarks.robot_files import MJCF

    kind = MJCF["go2"]
    return small() if kind.absent else kind.place().read_text(encoding="utf-8")


def draw_mjcf(draw: random.Random) -> tuple[bytes, list[str]]:
    """A robot with damage to attributes and elements, with parts of its own put in, and bytes."""
    text, done = draw.choice((small, small, real))(), []
    for _ in range(draw.choice((1, 1, 1, 2, 3, 5))):
        kind = draw.choice(
            ("attribute", "attribute", "attribute", "reference", "element", "insert", "insert", "head", "raw")
        )
        found = list((_ELEMENT if kind == "element" else _ATTRIBUTE).finditer(text))
        if kind == "head" or not found:
            text, kind = draw.choice(HEADS) + text, "head"
        elif kind == "insert":
            text = text.replace("<worldbody>", draw.choice(INSERTED) + "<worldbody>", 1)
        elif kind == "element":
            at = draw.choice(found)
            text = text[: at.start()] + draw.choice(("", at.group() * 2, draw.choice(found).group())) + text[at.end() :]
        else:
            at = draw.choice(found)
            new = draw.choice(found).group(1) if kind == "reference" else draw.choice((*VALUES, *ATTRIBUTES, *NAMES))
            value = f'"{draw.choice(RAW)}"' if kind == "raw" else quoted(new)
            text = f"{text[: at.start()]}={value}{text[at.end() :]}"
        done.append(kind)
    content = text.encode("utf-8", "surrogatepass")
    if draw.random() < 0.15:
        content, what = damaged(content, draw)
        done.append(what)
    return content, done


def read_mjcf(path: Path) -> Any:
    """Load a robot, by the names of the feet that the file has; ask for what records ask for."""
    from amble.robot import load_robot

    logging.getLogger("amble").setLevel(logging.ERROR)  # what MuJoCo warns of is told as a notice

    text = path.read_bytes().decode("utf-8", "ignore")
    pairs = (("l", "l_foot"), ("r", "r_foot"), ("fl", "FL"), ("fr", "FR"))
    feet = {label: frame for label, frame in pairs if f'"{frame}"' in text}
    twins = None if len(feet) != 2 else (tuple(feet),)
    robot = load_robot(path, feet or {"l": "l_foot"}, twins=twins)  # type: ignore[arg-type]
    _ = (robot.hash, robot.mass, robot.leg_length, robot.legs)
    return robot
