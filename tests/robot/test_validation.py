"""A robot is what equations of motion take for granted, wherever it comes from: Python, a gait file, a URDF."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait.files import load_gait
from amble.robot import Robot
from amble.robot.parts import Foot, Joint, Link
from amble.robot.validation import MOST_JOINTS
from amble.types import frozen
from tests.robots import robot

GAIT = Path(__file__).parents[1] / "data" / "biped-of-small-basin.json"


def joint(number: int, **fields: Any) -> Callable[[Robot], Robot]:
    def changed(model: Robot) -> Robot:
        joints = list(model.joints)
        joints[number] = replace(joints[number], **fields)
        return replace(model, joints=tuple(joints))

    return changed


def link(number: int, **fields: Any) -> Callable[[Robot], Robot]:
    def changed(model: Robot) -> Robot:
        links = list(model.links)
        links[number] = replace(links[number], **fields)
        return replace(model, links=tuple(links))

    return changed


def foot(number: int, **fields: Any) -> Callable[[Robot], Robot]:
    def changed(model: Robot) -> Robot:
        feet = list(model.feet)
        feet[number] = replace(feet[number], **fields)
        return replace(model, feet=tuple(feet))

    return changed


def same_point(model: Robot) -> Robot:
    first = model.feet[0]
    return foot(1, link=first.link, offset=first.offset)(model)


CASES: dict[str, tuple[Callable[[Robot], Robot], str]] = {
    "gravity upwards": (lambda model: replace(model, gravity=-9.81), "gravity of robot .* is -9.81"),
    "no gravity": (lambda model: replace(model, gravity=0.0), "gravity of robot .* is 0"),
    "gravity no number": (lambda model: replace(model, gravity=float("nan")), "gravity of robot"),
    "tolerance no number": (lambda model: replace(model, symmetry_tolerance=float("nan")), "symmetry tolerance"),
    "tolerance negative": (lambda model: replace(model, symmetry_tolerance=-1.0), "symmetry tolerance"),
    "a link too few": (lambda model: replace(model, links=model.links[:-1]), "one more link than joints"),
    "its own parent": (joint(2, parent=3), "in a cycle"),
    "a cycle": (joint(0, parent=2), "in a cycle"),
    "child twice": (joint(0, child=2), "is joint 1, but moves link 2"),
    "parent below zero": (joint(0, parent=-1), "moves link 1 on link -1"),
    "parent beyond": (joint(0, parent=99), "on link 99"),
    "foot on the base": (foot(0, link=0), "is on the base"),
    "foot beyond": (foot(0, link=99), "link 99 of"),
    "foot below zero": (foot(0, link=-1), "is on link -1"),
    "two feet in one point": (same_point, "are the same point"),
    "axis of two": (joint(1, axis=frozen([0.0, 2.0, 0.0])), "axis of joint .* is 2 long"),
    "axis of nothing": (joint(1, axis=frozen([0.0, 0.0, 0.0])), "axis of joint .* is 0 long"),
    "a stretched frame": (joint(1, rotation=frozen(1.1 * np.eye(3))), "is no rotation"),
    "a mirrored frame": (joint(1, rotation=frozen(np.diag([1.0, 1.0, -1.0]))), "is no rotation"),
    "range backwards": (joint(1, lower=1.0, upper=-1.0), "range of joint"),
    "range no number": (joint(1, lower=float("nan")), "range of joint"),
    "effort negative": (joint(1, effort=-1.0), "largest effort"),
    "effort no number": (joint(1, effort=float("nan")), "largest effort"),
    "velocity no number": (joint(1, velocity=float("nan")), "largest velocity"),
    "mass negative": (link(2, mass=-0.5), "mass of link .* is -0.5"),
    "inertia negative": (link(2, inertia=frozen(np.diag([0.01, 0.01, -0.01]))), "not positive definite"),
    "inertia not symmetric": (
        link(2, inertia=frozen([[0.1, 0.01, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]])),
        "is not symmetric",
    ),
}


@pytest.mark.parametrize("change", [change for change, _ in CASES.values()], ids=list(CASES))
def test_a_robot_made_in_python_is_checked(change: Callable[[Robot], Robot]) -> None:
    said = next(sentence for known, sentence in CASES.values() if known is change)
    with pytest.raises(InputError, match=said):
        change(robot("astro"))


@pytest.mark.parametrize("name", CASES)
def test_a_robot_of_a_gait_file_is_checked(name: str, tmp_path: Path) -> None:
    """The same change in the file; what the file cannot say is refused when it is read."""
    tree = json.loads(GAIT.read_text(encoding="utf-8"))
    made = tree["robot"]
    plain = load_gait(GAIT).pattern.robot
    recorded: dict[str, Any] = {}

    class Kept(Exception):  # noqa: N818 - no error
        """The parts of the robot are there."""

    def keep(self: Robot) -> None:
        recorded.update(vars(self))
        raise Kept

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(Robot, "__post_init__", keep)
        with pytest.raises(Kept):
            CASES[name][0](plain)
    made["gravity"]["value"] = _number(recorded["gravity"])
    made["symmetry_tolerance"]["value"] = _number(recorded["symmetry_tolerance"])
    made["links"] = [_link(entry, part) for entry, part in zip(made["links"], recorded["links"], strict=False)]
    made["joints"] = [_joint(entry, part) for entry, part in zip(made["joints"], recorded["joints"], strict=True)]
    made["feet"] = [_foot(entry, part) for entry, part in zip(made["feet"], recorded["feet"], strict=True)]
    file = tmp_path / "gait.json"
    file.write_text(json.dumps(tree), encoding="utf-8")
    with pytest.raises(InputError) as refused:
        load_gait(file)
    assert "hash" not in str(refused.value)  # that would be refused whatever it says


def _number(value: float) -> Any:
    return "nan" if np.isnan(value) else float(value)


def _link(entry: Any, part: Link) -> Any:
    mass = {**entry["mass"], "value": part.mass}
    return {**entry, "mass": mass, "inertia": {**entry["inertia"], "value": part.inertia.tolist()}}


def _joint(entry: Any, part: Joint) -> Any:
    changed = {name: {**entry[name], "value": getattr(part, name).tolist()} for name in ("rotation", "axis")}
    limits = {name: {**entry[name], "value": _bound(getattr(part, name))} for name in ("effort", "velocity")}
    between = {**entry["range"], "value": [_bound(part.lower), _bound(part.upper)]}
    return {**entry, **changed, **limits, "range": between, "parent": part.parent, "child": part.child}


def _bound(value: float) -> Any:
    return str(value) if not np.isfinite(value) else value


def _foot(entry: Any, part: Foot) -> Any:
    return {**entry, "link": part.link, "offset": {**entry["offset"], "value": part.offset.tolist()}}


def test_a_robot_of_more_joints_than_are_computed_is_refused_at_once() -> None:
    """The mass matrix of a drawn file with 274 joints and a link without mass took 50 s of processor time."""
    last = robot("astro").joints[-1]
    count = len(robot("astro").joints)
    more = range(count + 1, MOST_JOINTS + 2)
    joints = [replace(last, name=f"more {number}", parent=number - 1, child=number) for number in more]
    links = [replace(robot("astro").links[-1], name=f"more {number}") for number in more]

    def longer(by: int) -> Robot:
        whole = robot("astro")
        return replace(whole, joints=(*whole.joints, *joints[:by]), links=(*whole.links, *links[:by]))

    assert len(longer(MOST_JOINTS - count).joints) == MOST_JOINTS
    with pytest.raises(InputError, match=f"has {MOST_JOINTS + 1} moving joints, at most {MOST_JOINTS}.*locked"):
        longer(MOST_JOINTS + 1 - count)


def test_a_link_without_mass_inside_a_leg_is_a_robot() -> None:
    """What hangs on it moves it."""
    light = link(2, mass=0.0, inertia=frozen(np.zeros((3, 3))))(robot("astro"))
    assert light.links[2].mass == 0.0


@pytest.mark.parametrize("seed", range(20))
def test_whatever_is_drawn_for_a_part_is_a_robot_or_one_sentence(seed: int) -> None:
    draw = np.random.default_rng(seed)
    values = (0.0, -0.0, -1.0, 1e12, 1e13, 1e308, float("nan"), float("inf"), 1e-320, 2)
    for _ in range(20):
        value = values[draw.integers(len(values))]
        part = draw.integers(3)
        if part == 0:
            inertia = np.array(robot("astro").links[2].inertia)
            inertia[draw.integers(3), draw.integers(3)] = value
            change = link(2, inertia=frozen(inertia), mass=float(values[draw.integers(len(values))]))
        elif part == 1:
            axis = np.array([0.0, 1.0, 0.0])
            axis[draw.integers(3)] = value
            change = joint(int(draw.integers(12)), axis=frozen(axis), effort=float(values[draw.integers(len(values))]))
        else:
            change = foot(int(draw.integers(4)), link=int(draw.integers(-3, 15)), offset=frozen([0.0, 0.0, value]))
        try:
            model = change(robot("astro"))
        except InputError as error:
            said = str(error)
        else:
            said = model.hash
        assert said.isprintable()
