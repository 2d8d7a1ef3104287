"""No road leads a hostile name into a record: gait files, URDF files and specifications refuse it in one sentence."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from xml.sax.saxutils import quoteattr

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait, save_gait, to_dict
from amble.hybrid import Domain, Stance, Transition
from amble.io.storage import dumps
from amble.names import LONGEST, check_distinct, check_name, identifier
from amble.robot import Robot, load_robot
from amble.robot.parts import BASE_COORDINATES
from amble.synthesis.specification import read_specification
from amble.synthesis.specified import problem_of
from tests.hostile import allowed, hostile_name
from tests.robots import path as robot_file

FEET = {"fl": "fl_foot", "fr": "fr_foot", "rl": "rl_foot", "rr": "rr_foot"}


def one_sentence(error: InputError) -> bool:
    return str(error).isprintable() and str(error) != ""


def drawn(seed: int, count: int) -> list[str]:
    random = np.random.default_rng(seed)
    return [hostile_name(random) for _ in range(count)]


@pytest.mark.parametrize("name", ["LFoot/FSR/Heel", "iris__/imu", "joint_0.0", "hüfte", "a b", "x" * LONGEST, "*/"])
def test_names_of_real_robots_and_any_printable_text_are_names(name: str) -> None:
    check_name("joint", name)


@pytest.mark.parametrize(
    "name", ["", " a", "a\n", "a\tb", "\0", "\ud800", "\u202ea", "\u00a0", "x" * (LONGEST + 1), 3, None]
)
def test_what_is_no_line_of_printable_text_is_no_name(name: Any) -> None:
    with pytest.raises(InputError, match="the name of a joint") as caught:
        check_name("joint", name)
    assert one_sentence(caught.value)


def test_distinct_names() -> None:
    check_distinct("foot", ["a", "b"])
    with pytest.raises(InputError, match="more than one foot is called 'a'"):
        check_distinct("foot", ["a", "b", "a"])


def test_words_are_their_own_identifiers_and_others_get_one_each() -> None:
    for word in ("D1", "left_stance", "A"):
        assert identifier(word) == word
    names = sorted({*drawn(1, 2000), identifier("a b"), "a b", "a_b", "a__b", "a-b", "_a", "a_", "9", ""})
    found = [identifier(name) for name in names]
    assert len(set(found)) == len(names)
    x = ca.SX.sym("x")
    for word in found:
        ca.Function(f"f_{word}", [x], [x])  # casadi refuses what is no identifier
        assert ca.Function(f"{word}_f", [x], [x]).name() == f"{word}_f"


def test_domains_and_transitions_of_any_name_become_functions() -> None:
    """casadi refused a space in the name of a function, so a domain could not be called "left stance"."""
    x = ca.SX.sym("x")
    domain = Domain.from_expressions("left stance", x, -x, signals={"a": x}, admissibility=x)
    assert domain.name == "left stance"
    assert Transition.from_expressions("left stance", "*/", x, x, x).name == "left stance->*/"
    with pytest.raises(InputError, match="the name of a domain"):
        Domain.from_expressions("a\nb", x, -x)


def changed(robot: Robot, kind: str, name: str) -> Robot:
    first: Any = getattr(robot, kind)[0]
    return replace(robot, **{kind: (replace(first, name=name), *getattr(robot, kind)[1:])}, twins=())


@pytest.mark.parametrize("kind", ["links", "joints", "feet"])
def test_the_robot_refuses_names_whatever_road_they_come_by(stabilised_gait: Gait, kind: str) -> None:
    robot = stabilised_gait.robot
    assert getattr(changed(robot, kind, "*/ new"), kind)[0].name == "*/ new"
    for name in (
        "a\nb",
        getattr(robot, kind)[1].name,
        *(("roll", "rate of x", "acceleration of x") if kind == "joints" else ()),
    ):
        with pytest.raises(InputError, match=r"the name of a|is called") as caught:
            changed(robot, kind, name)
        assert one_sentence(caught.value)


def test_twins_are_feet(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="unknown foot 'left'"):
        replace(stabilised_gait.robot, twins=(("left", "fr"),))


def test_the_other_records_refuse_names(stabilised_gait: Gait) -> None:
    gait, robot = stabilised_gait, stabilised_gait.robot
    stances = gait.pattern.stances
    for build in (
        lambda: replace(robot, name="a\nb"),
        lambda: replace(robot, source="\ud800.urdf"),
        lambda: replace(robot.feet[0], frame="\n"),
        lambda: Stance("a\nb", ("fl",)),
        lambda: replace(gait.pattern, name="a\nb"),
        lambda: replace(gait.pattern, stances=(stances[0], replace(stances[1], name=stances[0].name), *stances[2:])),
        lambda: replace(gait.solver, status="\ud800"),
        lambda: replace(gait, versions={"casadi": "\x1b[31m"}),
    ):
        with pytest.raises(InputError, match=r"the name of a|is called") as caught:
            build()
        assert one_sentence(caught.value)


def renamed(tree: Any, names: Mapping[str, str]) -> Any:
    """Rename texts and keys everywhere in a tree."""
    if isinstance(tree, dict):
        return {names.get(key, key): renamed(value, names) for key, value in tree.items()}
    if isinstance(tree, list):
        return [renamed(value, names) for value in tree]
    return names.get(tree, tree) if isinstance(tree, str) else tree


def fields(gait: Gait) -> list[str]:
    """Every text of a gait file that a user chooses; the names of what it holds."""
    robot = gait.robot
    links = [link.name for link in robot.links]
    return [robot.name, robot.source, gait.pattern.name, *links[:3], *robot.joint_names[:3], *robot.foot_names[:2]]


def rehashed(tree: Any, gait: Gait, names: Mapping[str, str]) -> Any:
    """Write the hash that the renamed robot has, so that nothing but its names can be refused."""
    robot = gait.robot
    links = tuple(replace(link, name=names.get(link.name, link.name)) for link in robot.links)
    joints = tuple(replace(joint, name=names.get(joint.name, joint.name)) for joint in robot.joints)
    feet = tuple(replace(foot, name=names.get(foot.name, foot.name)) for foot in robot.feet)
    twins = tuple((names.get(left, left), names.get(right, right)) for left, right in robot.twins)
    tree["robot"]["hash"] = replace(robot, links=links, joints=joints, feet=feet, twins=twins).hash
    return tree


def test_hostile_texts_in_a_gait_file(stabilised_gait: Gait, tmp_path: Path) -> None:
    """Every text is drawn in turn: what is a name loads and is written back the same, all else is one sentence."""
    gait = replace(stabilised_gait, multipliers=None)
    file, outcomes = tmp_path / "gait.json", {True: 0, False: 0}
    head = {"format": "amble gait", "format_version": 3, "versions": dict(gait.versions)}
    plain = json.loads(dumps({**head, **to_dict(gait)}))
    for number, name in enumerate(drawn(2, 40)):
        old = fields(gait)[number % len(fields(gait))]
        sound = allowed(name) and name not in (*fields(gait), "x", "roll") and not name.startswith("rate of ")
        tree = renamed(plain, {old: name})
        if sound:
            tree = rehashed(tree, gait, {old: name})
        file.write_text(json.dumps(tree))
        outcomes[sound] += 1
        if sound:
            again = load_gait(file)
            assert name in fields(again)
            assert load_gait(save_gait(again, file)).robot == again.robot
        else:
            with pytest.raises(InputError) as caught:
                load_gait(file)
            assert one_sentence(caught.value)
    assert min(outcomes.values()) > 8


@pytest.mark.parametrize(
    "place",
    ["status", "key", *(pytest.param(other, marks=pytest.mark.slow) for other in ("solver", "casadi", "law", "unit"))],
)
def test_hostile_texts_elsewhere_in_a_gait_file(stabilised_gait: Gait, tmp_path: Path, place: str) -> None:
    file = tmp_path / "gait.json"
    text = save_gait(stabilised_gait, file).read_text()
    for name in drawn(3, 40):
        tree = json.loads(text)
        if place in ("status", "solver"):
            tree["solver"][place] = name
        elif place == "casadi":
            tree["versions"][place] = name
        elif place == "law":
            tree["allocation_law"]["name"] = name
        elif place == "unit":
            tree["speed"]["unit"] = name
        else:
            tree["limits"][name] = 1
        file.write_text(json.dumps(tree))
        if place in ("status", "solver", "casadi") and allowed(name):
            load_gait(file)
            continue
        with pytest.raises(InputError) as caught:
            load_gait(file)
        assert one_sentence(caught.value)


def test_hostile_names_in_a_urdf(tmp_path: Path) -> None:
    text = robot_file("astro").read_text()
    file = tmp_path / "robot.urdf"
    loaded, refused = 0, []
    for number, name in enumerate(drawn(4, 150)):
        old = ("astro", "fl_knee", "rr_hip_yaw", "fl_foot", "body")[number % 5]
        assert f'"{old}"' in text
        file.write_bytes(text.replace(f'"{old}"', quoteattr(name)).encode("utf-8", "surrogatepass"))
        feet = {label: frame if frame != old else name for label, frame in FEET.items()}
        try:
            robot = load_robot(file, feet)
        except InputError as error:
            refused.append((name, error))
        else:
            loaded += 1
            known = (robot.name, *(each.name for each in (*robot.links, *robot.joints, *robot.feet)))
            assert all(map(allowed, known))
    assert loaded > 30
    for name, error in refused:
        assert one_sentence(error)
        assert not allowed(name) or name in BASE_COORDINATES or name.startswith("rate of ")


SPECIFICATION = """
[robot]
file = "robot.urdf"
feet = { FL = "fl_foot", fr = "FRAME", rl = "rl_foot", rr = "rr_foot" }
twins = [["FL", "fr"], ["rl", "rr"]]
[gait]
stances = [["fr", "rl"], ["fr", "rr"], ["FL", "rr"], ["FL", "STANDS"]]
mirrored = true
speed = "SPEED"
[outputs]
free = { "DOMAIN" = ["FREE"] }
[law]
name = "LAW"
[limits]
clearance = "20 mm"
normal_force = "10 N"
duration = ["10 ms", 0.15]
torque = 50
speed = 20
acceleration = 100
torques = { "JOINT" = 30 }
touchdown_velocity = { x = [-0.2, 0.3], y = ["-10 cm/s", 0.1], z = [-2, -0.06] }
[posture]
height = 0.6
angles = { ANGLES }
[solver]
"KEY" = 20
"""
SOUND = {
    "FL": "fl",
    "FRAME": "fr_foot",
    "STANDS": "rl",
    "SPEED": "0.2 m/s",
    "DOMAIN": "D1",
    "FREE": "rl_hip_pitch",
    "LAW": "pinv",
    "JOINT": "fl_knee",
    "KEY": "intervals",
}


def test_hostile_labels_in_a_specification(stabilised_gait: Gait, tmp_path: Path) -> None:
    """Only the labels of feet are the user's own; any other text must be one that is known."""
    (tmp_path / "robot.urdf").write_bytes(robot_file("astro").read_bytes())
    file = tmp_path / "spec.toml"
    angles = ", ".join(f"{name} = 0.5" for name in stabilised_gait.robot.joint_names)
    posed, refused = 0, []
    for number, name in enumerate(["fl", *drawn(5, 90)]):
        place = "FL" if number % 3 == 0 else list(SOUND)[number % len(SOUND)]
        texts = {**SOUND, place: name}
        text = SPECIFICATION.replace("ANGLES", angles)
        for word in SOUND:
            quoted = json.dumps(texts[word]).replace("\x7f", "\\u007f")
            text = text.replace(f'"{word}"', quoted).replace(f"{{ {word} = ", f"{{ {quoted} = ")
        file.write_bytes(text.encode("utf-8", "surrogatepass"))
        try:
            problem = problem_of(read_specification(file), tmp_path)
        except InputError as error:
            refused.append(error)
        else:
            posed += 1
            assert allowed(name)
            assert name in problem.pattern.robot.foot_names
    assert posed > 6
    assert all(map(one_sentence, refused))
