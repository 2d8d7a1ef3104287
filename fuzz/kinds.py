"""The kinds of input: how one is drawn from a seed, and how amble reads it."""

from __future__ import annotations

import json
import random
import re
import tempfile
import tomllib
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from importlib import resources
from pathlib import Path
from typing import Any

from fuzz import gait_bases, robots, toml
from fuzz.bytes import damaged
from fuzz.trees import as_json, damage, with_literals
from fuzz.words import NAMES, SCALARS

FOLDER = Path(tempfile.gettempdir())
FEET = (("l", "l3"), ("r", "l2"), ("fl", "fl_foot"), ("fr", "fr_foot"))


@dataclass(frozen=True)
class Kind:
    """One kind of input.

    Attributes:
        name: what it is called on the command line and in failures.
        suffix: of its files.
        share: how often it is drawn, relative to the others.
        draw: random numbers -> content, as (content, what was done to it).
        read: reads a file with everything that amble does on the way to its work; refusing is an ``InputError``.
    """

    name: str
    suffix: str
    share: float
    draw: Callable[[random.Random], tuple[bytes, list[str]]]
    read: Callable[[Path], Any]


def drawn(kind: Kind, seed: int) -> tuple[bytes, list[str]]:
    """Return the input of a seed and what was done to it; the same in every process."""
    return kind.draw(random.Random(f"{kind.name} {seed}"))


def _often(draw: random.Random) -> int:
    return draw.choice((1, 1, 1, 2, 3, 5))


def _then_bytes(content: bytes, done: list[str], draw: random.Random) -> tuple[bytes, list[str]]:
    if draw.random() < 0.12:
        content, what = damaged(content, draw)
        done.append(what)
    return content, done


def _damaged_tree(tree: dict[str, Any], draw: random.Random) -> list[str]:
    return [damage(tree, draw) for _ in range(_often(draw)) if tree]


# gait files ----------------------------------------------------------------------------------------------------------


def draw_gait(draw: random.Random) -> tuple[bytes, list[str]]:
    """A gait file with damage; the hash of a damaged robot is computed anew, so that it is not all that is seen."""
    tree = json.loads(gait_bases.small(draw.randrange(12)))
    if draw.random() < 0.5:  # large parts hide small ones
        part = draw.choice([key for key in tree if isinstance(tree[key], dict)])
        inside = {part: tree[part]}
        done = _damaged_tree(inside, draw)
        del tree[part]
        tree.update(inside)
    else:
        done = _damaged_tree(tree, draw)
    if draw.random() < 0.9:
        rehash(tree)
    return _then_bytes(as_json(tree, draw), done, draw)


def rehash(tree: dict[str, Any]) -> None:
    """Give the robot of a gait file the hash that belongs to it, where it is one."""
    from amble.errors import AmbleError
    from amble.io.codec import Record
    from amble.robot.files import ROBOT, robot_of

    def build(hash: str, **fields: Any) -> str:  # noqa: ARG001 - the one it has now
        return robot_of(**fields).hash

    try:
        tree["robot"]["hash"] = Record(build, ROBOT._fields).decode(tree["robot"], "robot")
    except (AmbleError, KeyError, TypeError, AttributeError):
        return


def read_gait(path: Path) -> Any:
    """Load a gait, write it and hash it."""
    from amble.gait.files import content_hash, load_gait, save_gait

    gait = load_gait(path)
    content_hash(gait)
    back = load_gait(save_gait(gait, path.with_suffix(".again")))
    if content_hash(back) != content_hash(gait):
        raise AssertionError("a gait that was loaded and saved reads back as another")
    return gait


# robots --------------------------------------------------------------------------------------------------------------

_ATTRIBUTE = re.compile(r'(?<=[a-z])="([^"<>]*)"')
_ELEMENT = re.compile(r"<(\w+)[^<>]*/>|<(inertial|joint|link)\b.*?</\2>", re.DOTALL)
_HEADS = (
    *("\n\n", "\ufeff", "<!-- -->", "<?xml", "\x00", "<!DOCTYPE a [<!ENTITY bomb 'c'>]>", '<?xml version="1.0"?>'),
    *(f'<?xml version="1.0" encoding="{name}"?>' for name in ("utf-16", "gb2312", "latin-1", "idna", "hex", "utf-7")),
)


def draw_urdf(draw: random.Random) -> tuple[bytes, list[str]]:
    """A drawn robot with damage to attributes and elements."""
    return damaged_xml(robots.urdf(draw), draw)


def damaged_xml(text: str, draw: random.Random) -> tuple[bytes, list[str]]:
    """Damage to attributes and elements of a robot file."""
    done = []
    for _ in range(_often(draw)):
        kind = draw.choice(("attribute", "attribute", "attribute", "reference", "element", "head", "raw", "space"))
        found = list((_ELEMENT if kind == "element" else _ATTRIBUTE).finditer(text))
        if kind == "head" or not found:
            text = draw.choice(_HEADS) + text
            kind = "head"
        elif kind == "space":
            text = text.replace("<robot ", '<robot xmlns="http://x" ', 1)
        elif kind == "element":
            at = draw.choice(found)
            text = text[: at.start()] + draw.choice(("", at.group() * 2, draw.choice(found).group())) + text[at.end() :]
        else:
            at = draw.choice(found)
            new = draw.choice(found).group(1) if kind == "reference" else draw.choice((*robots.ATTRIBUTES, *NAMES))
            value = f'"{draw.choice(robots.RAW)}"' if kind == "raw" else robots.quoted(new)
            text = f"{text[: at.start()]}={value}{text[at.end() :]}"
        done.append(kind)
    return _then_bytes(text.encode("utf-8", "surrogatepass"), done, draw)


def read_urdf(path: Path) -> Any:
    """Load a robot and ask for what commands and records ask for: hash, size, physics, mirror."""
    from amble.errors import InputError
    from amble.robot import load_robot
    from amble.robot.plausibility import physical_rows

    text = path.read_bytes()[:100_000].decode("utf-8", "ignore")
    feet = {label: frame for label, frame in FEET if f'"{frame}"' in text}
    twins = None if len(feet) != 2 else (tuple(feet),)
    robot = load_robot(path, feet or {"l": "l1"}, twins=twins)  # type: ignore[arg-type]
    _ = (robot.hash, robot.mass, robot.leg_length, robot.legs)
    if len(robot.joints) > 60:
        return robot
    physical_rows(robot, mirrored=False)
    try:
        _ = robot.mirror
    except InputError:  # it has none
        return robot
    physical_rows(robot, mirrored=True)
    return robot


# specifications ------------------------------------------------------------------------------------------------------


@cache
def _specification() -> dict[str, Any]:
    return tomllib.loads((resources.files("amble.specifications") / "astro-amble.toml").read_text(encoding="utf-8"))


def _other_specification(draw: random.Random) -> dict[str, Any]:
    """A specification of a robot from a file, with everything that it must say, and parts that it may."""
    joints = biped_joints()
    tree: dict[str, Any] = {
        "robot": {"file": "biped.urdf", "feet": {"l": "l_foot", "r": "r_foot"}, "twins": [["l", "r"]], "gravity": 9.8},
        "gait": {"speed": "0.2 m/s", "stances": [["l"], ["r"]], "mirrored": True},
        "limits": {
            **{"clearance": "2 cm", "normal_force": 5.0, "duration": [0.1, "0.3 s"], "torque": "60 N m"},
            **{"torques": {joints[0]: 30.0}, "speed": "8 rad/s", "speeds": {}, "acceleration": 60.0},
            **{"base": {"z": [0.3, 0.6], "roll": ["-5 deg", "5 deg"]}, "joints": {joints[2]: [-1.0, 0.0]}},
            **{"touchdown_velocity": {"x": [-0.2, 0.3], "y": [-0.1, 0.1], "z": [-2.0, 0.0]}},
        },
        "ground": {"friction": 0.6, "slope": "3 deg", "heading": 0.0},
        "contact": {"name": "point"},
        "outputs": {"order": 4, "free": {}, "position_gain": 100.0, "velocity_gain": 20.0},
        "law": {"name": "weighted", "parameters": {"weights": {joints[0]: 2.0}}},
        "posture": {"height": "0.5 m", "angles": dict.fromkeys(joints, "5 deg")},
        "solver": {"intervals": 5, "refinement": 1, "tolerance": 1e-8, "iterations": 100},
    }
    law, parameters = draw.choice(gait_bases.LAWS)
    if draw.random() < 0.5:
        tree["law"] = {"name": law, "parameters": parameters}
    return tree


def biped_joints() -> tuple[str, ...]:
    """Names of the joints of the file ``biped.urdf`` beside every specification."""
    return robots.biped().joint_names


def draw_specification(draw: random.Random) -> tuple[bytes, list[str]]:
    """A specification with damage; two in five are of a robot of the catalogue, whose loading takes longer."""
    tree = json.loads(json.dumps(_specification() if draw.random() < 0.4 else _other_specification(draw)))
    done = _damaged_tree(tree, draw)
    text = with_literals(toml.as_toml(tree), draw)
    if draw.random() < 0.1:
        lines = text.splitlines()
        at = draw.randrange(len(lines) + 1)
        lines.insert(at, draw.choice(("[limits]", "[[gait]]", "[a.b]", "[robot.feet]", *lines[:8], "a.b.c = 1", "=")))
        text = "\n".join(lines)
        done.append(f"line at {at}")
    return _then_bytes(text.encode("utf-8", "surrogatepass"), done, draw)


def read_specification(path: Path) -> Any:
    """Read a specification and build its gait problem."""
    from amble.workflow.specified import pose

    beside = path.with_name("biped.urdf")
    if not beside.exists():
        beside.write_text(biped_urdf(), encoding="utf-8")
    return pose(path)


@cache
def biped_urdf() -> str:
    """The biped as a URDF file."""
    robot = robots.biped()
    lines = ['<robot name="biped">']
    for link in robot.links:
        inertia = " ".join(f'i{"xyz"[i]}{"xyz"[j]}="{link.inertia[i, j]}"' for i in range(3) for j in range(i, 3))
        at = " ".join(map(str, link.center))
        lines.append(
            f'<link name="{link.name}"><inertial><origin xyz="{at}"/><mass value="{link.mass}"/><inertia {inertia}/>'
            "</inertial></link>"
        )
    for joint in robot.joints:
        parent, child = robot.links[joint.parent].name, robot.links[joint.child].name
        at, axis = " ".join(map(str, joint.translation)), " ".join(map(str, joint.axis))
        lines.append(
            f'<joint name="{joint.name}" type="revolute"><parent link="{parent}"/><child link="{child}"/>'
            f'<origin xyz="{at}"/><axis xyz="{axis}"/><limit lower="-1.5" upper="1.5" effort="60"/></joint>'
        )
    for foot in robot.feet:
        at, on = " ".join(map(str, foot.offset)), robot.links[foot.link].name
        lines.append(
            f'<link name="{foot.frame}"/><joint name="{foot.frame}_joint" type="fixed"><parent link="{on}"/>'
            f'<child link="{foot.frame}"/><origin xyz="{at}"/></joint>'
        )
    return "\n".join([*lines, "</robot>"])


# results.json --------------------------------------------------------------------------------------------------------


def _results() -> dict[str, Any]:
    return {
        "format": "amble results",
        "format_version": 1,
        "robot": "biped",
        "settings": {"tolerance": "1e-8", "cycles": "500"},
        "seconds": {"synthesis": 4.5, "simulation": 1.25},
        "spectral_radius": {"initial": 1.4, "stabilized": 0.36, "error": 1e-6, "contraction_bound": None},
        "stabilization": {"seconds": 3.0, "steps": 4, "parameters": 12, "bound": 0.5, "reason": "converged"},
        "stability_versions": {"casadi": "3.8.2", "numpy": "2.4.0"},
        "multipliers": {"initial": [[1.4, 0.0], [0.1, 0.2]], "stabilized": [[0.36, 0.0], [0.1, -0.2]]},
        "contraction": {"predicted": 0.36, "measured": 0.361, "relative_difference": 0.002},
        "section_error": 1e-9,
        "section_error_perturbed": 1e-8,
        "section_distances": [1e-3, 3e-4, 1e-4],
        "perturbed": {
            **{"size": 0.01, "seed": 3, "cycles": 500, "ended": "completed", "sound_from_cycle": 2},
            "before_sound": {"min_normal_force": 3.5, "max_friction": 0.7},
        },
    }


def draw_results(draw: random.Random) -> tuple[bytes, list[str]]:
    """A results.json with damage."""
    tree = _results()
    done = _damaged_tree(tree, draw)
    return _then_bytes(as_json(tree, draw), done, draw)


def read_results(path: Path) -> Any:
    """Read what ``amble report`` keeps of an earlier run, and write it into the page's table."""
    from amble.report.findings import stability_table
    from amble.report.results import read_results, seconds_from, settings_from
    from amble.report.stability_results import stability_from

    tree = read_results(path)
    found = settings_from(tree), seconds_from(tree), stability_from(tree)
    if found[2] is not None:
        stability_table(found[2].results).text()
    return found


# law words -----------------------------------------------------------------------------------------------------------

_VALUES = (
    *("1", "0", "-1", "1.5", "1e999", "0.5", "null", "true", "paper", "datasheet", "[]", "[1]", '["l_knee"]', "{}"),
    *('{"l_knee": 2}', '{"l_knee": -1}', '{"l_knee": [1]}', '{"x": 1}', "[[", "]", "9" * 5000, "NaN", "[" * 200),
    *('{"name": "a"}', '"\\ud800"', "l_knee", '["l_knee", "r_knee"]', "1_0", "inf", "-inf", "nan", "{", '{"a": 1e308}'),
    *('{"torque_constant": 1}', '{"name": "m", "heat": 1.0, "recovery": 0.0}', '{"l_knee": 1e-320, "r_knee": 1e300}'),
)


def draw_law(draw: random.Random) -> tuple[bytes, list[str]]:
    """A word such as ``power:actuator=datasheet``; a NUL or a surrogate cannot be part of a command line."""
    known = ("pinv", "drop", "weighted", "power", "peak", "bounded")
    keys = ("joints", "weights", "actuator", "friction", "normal_force", "a", "", " ")
    word = draw.choice(known if draw.random() < 0.9 else NAMES)
    parts = []
    for _ in range(draw.choice((0, 1, 1, 1, 2, 3))):
        value = draw.choice((draw.choice(_VALUES), draw.choice(_VALUES), draw.choice(NAMES), json.dumps(_plain(draw))))
        form = draw.choice(("{}={}", "{}={}", "{}={}", "{}={}", "{}={}", "{}", " {} = {} "))
        own = {"drop": "joints", "weighted": "weights", "power": "actuator"}.get(word, "friction")
        parts.append(form.format(own if draw.random() < 0.7 else draw.choice(keys), value))
    word += (
        draw.choice((":", ":", ":", ":", ":", ":", "", "=")) + ",".join(parts)
        if parts
        else draw.choice(("", ":", ":,,"))
    )
    content = word.encode("utf-8", "replace").replace(b"\x00", b"")
    if draw.random() < 0.2:
        content = damaged(content, draw)[0].replace(b"\x00", b"")
    return content, ["word"]


def _plain(draw: random.Random) -> Any:
    found = draw.choice(SCALARS)
    return found if found == found and found not in (float("inf"), float("-inf")) else "inf"


def read_law(path: Path) -> Any:
    """Make a law of a word, write it into a gait file's entry, and derive what it evaluates in a stance."""
    from amble.cli.options import parse_law
    from amble.control.allocation.registry import LAWS
    from amble.gait.files import from_dict

    word = path.read_bytes().decode("utf-8", "surrogateescape")
    tree = json.loads(gait_bases.small(1))
    del tree["format"], tree["format_version"]
    law = parse_law(word, _small_gait(tree, from_dict).pattern)
    entry = json.loads(json.dumps(LAWS.encode(law, "law"), allow_nan=False))
    if LAWS.decode(entry, "law") != law:
        raise AssertionError("a law that was written reads back as another")
    return law


_KEPT: dict[str, Any] = {}


def _small_gait(tree: dict[str, Any], build: Callable[[Any], Any]) -> Any:
    if "gait" not in _KEPT:
        _KEPT["gait"] = build(tree)
    return _KEPT["gait"]
