"""Loading: what a file may say, what it may not, and one sentence for each."""

from __future__ import annotations

import re
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from amble.errors import AmbleError, InputError, UnknownNameError
from amble.robot import Robot, dynamics, kinematics, load_robot
from tests.robots import ROBOTS, path, robot

Write = Callable[[str], Path]

BODY = (
    '<inertial><mass value="2"/><inertia ixx="0.1" ixy="0" ixz="0" iyy="0.1" iyz="0" izz="0.1"/></inertial>'
    '<visual><geometry><mesh filename="package://nowhere/body.stl"/></geometry></visual>'
)
LIMIT = '<limit lower="-1" upper="1" effort="10" velocity="5"/>'


def link(name: str, inside: str = BODY) -> str:
    return f'<link name="{name}">{inside}</link>'


def joint(name: str, parent: str, child: str, kind: str = "revolute", inside: str = LIMIT, axis: str = "0 1 0") -> str:
    return (
        f'<joint name="{name}" type="{kind}"><parent link="{parent}"/><child link="{child}"/>'
        f'<origin xyz="0.1 0 0" rpy="0 0 0"/><axis xyz="{axis}"/>{inside}</joint>'
    )


HOPPER = (
    link("body")
    + link("leg")
    + link("toe", "")
    + joint("hip", "body", "leg")
    + joint("ankle", "leg", "toe", "fixed", inside="")
)


@pytest.fixture
def write(tmp_path: Path) -> Write:
    def write(inside: str) -> Path:
        file = tmp_path / "robot.urdf"
        file.write_text(f'<?xml version="1.0"?><robot name="hopper">{inside}</robot>')
        return file

    return write


def load(file: Path, gravity: float = 9.81) -> Robot:
    return load_robot(file, {"toe": "toe"}, gravity)


def test_hopper_loads_without_its_mesh(write: Write) -> None:
    hopper = load(write(HOPPER))
    assert (hopper.name, hopper.source, hopper.joint_names, hopper.foot_names) == (
        "hopper",
        "robot.urdf",
        ("hip",),
        ("toe",),
    )
    assert hopper.legs == {"toe": ("hip",)}
    assert hopper.gravity == 9.81
    np.testing.assert_allclose(
        np.asarray(kinematics.foot_position(hopper, "toe", np.zeros(7))).ravel(), [0.2, 0.0, 0.0], atol=1e-16
    )


def test_a_foot_may_be_named_by_its_joint(write: Write) -> None:
    file = write(HOPPER)
    by_joint, by_link = load_robot(file, {"a": "ankle"}), load_robot(file, {"a": "toe"})
    np.testing.assert_array_equal(by_joint.feet[0].offset, by_link.feet[0].offset)
    assert by_joint.hash == by_link.hash


def test_a_massless_root_may_carry_the_base(write: Write) -> None:
    plain = load(write(HOPPER))
    floating = load(write(link("world", "") + HOPPER + joint("free", "world", "body", "floating", inside="")))
    assert floating.hash == plain.hash
    fixed = load(write(link("root", "") + HOPPER + joint("on", "root", "body", "fixed", inside="")))
    assert fixed.mass == plain.mass
    assert fixed.links[0].name == "root"
    np.testing.assert_allclose(fixed.links[0].center, [0.1, 0.0, 0.0])


def test_continuous_joints_have_no_limits(write: Write) -> None:
    hopper = load(write(HOPPER.replace('type="revolute"', 'type="continuous"')))
    assert (hopper.joints[0].lower, hopper.joints[0].upper) == (-np.inf, np.inf)
    assert hopper.joints[0].effort == 10.0


def test_missing_limits_are_infinite(write: Write) -> None:
    only = load(write(HOPPER.replace(LIMIT, "")))
    assert (only.joints[0].lower, only.joints[0].upper, only.joints[0].effort, only.joints[0].velocity) == (
        -np.inf,
        np.inf,
        np.inf,
        np.inf,
    )


def test_joint_order_and_parents_later_in_the_file(write: Write) -> None:
    """The shin's joint stands before the thigh's: order stays, recursions still go from the base outwards."""
    swapped = load_robot(
        write(
            link("toe") + link("thigh") + link("body") + joint("knee", "thigh", "toe") + joint("hip", "body", "thigh")
        ),
        {"toe": "toe"},
    )
    straight = load_robot(
        write(
            link("body") + link("thigh") + link("toe") + joint("hip", "body", "thigh") + joint("knee", "thigh", "toe")
        ),
        {"toe": "toe"},
    )
    assert swapped.joint_names == ("knee", "hip")
    assert swapped.legs == straight.legs == {"toe": ("hip", "knee")}
    q, v = np.random.default_rng(0).normal(size=(2, 8))
    order = [*range(6), 7, 6]
    for function in (dynamics.bias, dynamics.kinetic_energy):
        ours = np.asarray(function(swapped, q, v)).ravel()
        expected = np.asarray(function(straight, q[order], v[order])).ravel()
        np.testing.assert_allclose(ours, expected if ours.size == 1 else expected[order], rtol=1e-12)


@pytest.mark.parametrize("name", ROBOTS)
def test_merging_keeps_the_mass_of_the_file(name: str) -> None:
    masses = [float(value) for value in re.findall(r'<mass\s+value="([^"]+)"', path(name).read_text())]
    assert robot(name).mass == pytest.approx(sum(masses), rel=1e-14)


NAN = BODY.replace('ixx="0.1"', 'ixx="nan"')
FLAT = BODY.replace('ixx="0.1"', 'ixx="-0.01"')

BAD = {
    "no joint at all": (link("toe"), "the robot has no actuated joint"),
    "no link": ("", "the robot has no link"),
    "massless leg": (HOPPER.replace(link("leg"), link("leg", "")), r"moving link 'leg' has no mass \(0 kg\)"),
    "negative mass": (HOPPER.replace('mass value="2"', 'mass value="-2"'), "mass of link 'body' is -2 kg"),
    "massless base": (HOPPER.replace(link("body"), link("body", "")), "'body' has no mass .*fixed-base robot"),
    "bolted to the world": (
        link("world", "") + HOPPER + joint("on", "world", "body", "fixed", inside=""),
        "the robot is fixed to the link 'world', a floating base is needed",
    ),
    "nan": (HOPPER.replace(link("leg"), link("leg", NAN)), "link 'leg', ixx is 'nan', not a finite number"),
    "infinite mass": (HOPPER.replace('mass value="2"', 'mass value="inf"'), "mass is 'inf', not a finite number"),
    "word for a number": (HOPPER.replace('mass value="2"', 'mass value="two"'), "mass is 'two', not a number"),
    "negative inertia": (
        HOPPER.replace(link("leg"), link("leg", FLAT)),
        "inertia of link 'leg' is not positive definite",
    ),
    "two numbers": (HOPPER.replace('xyz="0.1 0 0"', 'xyz="0.1 0"'), "origin xyz is '0.1 0', not three numbers"),
    "zero axis": (HOPPER.replace('axis xyz="0 1 0"', 'axis xyz="0 0 0"'), "'hip' has an axis of length zero"),
    "crossed limits": (HOPPER.replace('lower="-1"', 'lower="2"'), "lower limit 2 above its upper limit 1"),
    "nan limit": (HOPPER.replace('effort="10"', 'effort="nan"'), "limit effort is 'nan'"),
    "planar": (
        HOPPER.replace('type="revolute"', 'type="planar"'),
        "joint 'hip' is planar; known: revolute, continuous, prismatic, fixed; hold it: locked = { hip = 0.0 }",
    ),
    "mimic": (
        HOPPER.replace(LIMIT, LIMIT + '<mimic joint="knee"/>'),
        "joint 'hip' mimics 'knee', .*locked = { hip = 0.0 }",
    ),
    "no parent": (HOPPER.replace('<parent link="body"/>', ""), "joint 'hip' has no parent link"),
    "no type": (HOPPER.replace(' type="revolute"', ""), "'joint' element without 'type'"),
    "no mass element": (HOPPER.replace('<mass value="2"/>', ""), "inertial element without mass"),
    "missing inertia entry": (HOPPER.replace('ixy="0" ', ""), "'inertia' element without 'ixy'"),
    "unknown link": (HOPPER.replace('child link="leg"', 'child link="arm"'), "unknown link .*'arm'; known: body, leg"),
    "link twice": (HOPPER + link("leg"), "link 'leg' is defined more than once"),
    "joint twice": (HOPPER + joint("hip", "body", "leg"), "joint 'hip' is defined more than once"),
    "two parents": (HOPPER + joint("second", "body", "leg"), "'leg' hangs on two joints, 'hip' and 'second'; .*cut"),
    "two roots": (HOPPER + link("stray"), "more than one root link: body, stray"),
    "all in a cycle": (
        link("a") + link("toe") + joint("j", "a", "toe") + joint("k", "toe", "a"),
        "the joints form a cycle",
    ),
    "a cycle beside the tree": (
        HOPPER + link("a") + link("b") + joint("j", "a", "b") + joint("k", "b", "a"),
        "'b' is in a cycle",
    ),
    "a fixed cycle beside the tree": (
        HOPPER + link("a") + link("b") + joint("j", "a", "b", "fixed") + joint("k", "b", "a", "fixed"),
        "'b' is not connected to the base 'body'",
    ),
    "floating leg": (
        HOPPER.replace('type="revolute"', 'type="floating"'),
        "the only floating joint allowed carries the base",
    ),
    "macros": (
        '<xacro:macro xmlns:xacro="http://www.ros.org/wiki/xacro" name="leg"/>' + HOPPER,
        "holds xacro macros; expand them first",
    ),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_files_are_refused_in_one_sentence(what: str, write: Write) -> None:
    inside, sentence = BAD[what]
    with pytest.raises(InputError, match=sentence) as caught:
        load(write(inside))
    assert "\n" not in str(caught.value)
    assert caught.value.exit_code == 2


def test_a_file_that_is_not_there() -> None:
    with pytest.raises(InputError, match=r"robot file 'nowhere.urdf' cannot be read: No such file"):
        load(Path("nowhere.urdf"))


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b"", "is not well-formed XML"),
        (b"<robot", "is not well-formed XML"),
        (b"\xff\xfe\x00<robot", "is not text in the encoding 'utf-16'"),
        (b"<mujoco/>", "is not a URDF: its root element is 'mujoco', not 'robot'"),
    ],
)
def test_content_that_is_no_urdf(content: bytes, sentence: str, tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_bytes(content)
    with pytest.raises(InputError, match=sentence):
        load(file)
    (tmp_path / "folder.urdf").mkdir()
    with pytest.raises(InputError, match="cannot be read"):
        load(tmp_path / "folder.urdf")


@pytest.mark.parametrize("length", range(0, 2000, 37))
def test_a_truncated_file_raises_nothing_else(length: int, tmp_path: Path) -> None:
    file = tmp_path / "robot.urdf"
    file.write_bytes(path("astro").read_bytes()[:length])
    with pytest.raises(AmbleError):
        load_robot(file, {"fl": "fl_foot"})


def test_unknown_feet_and_twins_list_what_exists(write: Write) -> None:
    file = write(HOPPER)
    with pytest.raises(UnknownNameError, match="unknown link or joint for foot 'a' 'paw'; known: body, leg, toe"):
        load_robot(file, {"a": "paw"})
    with pytest.raises(UnknownNameError, match="unknown foot 'b'; known: a"):
        load_robot(file, {"a": "toe"}, twins=[("a", "b")])
    with pytest.raises(InputError, match="feet 'a' and 'b' of robot 'hopper' are the same point of 'leg'"):
        load_robot(file, {"a": "toe", "b": "ankle"})
    with pytest.raises(InputError, match="gravity of robot 'hopper' holds nan"):
        load(file, gravity=float("nan"))


def test_a_default_namespace_changes_nothing(tmp_path: Path) -> None:
    text = path("astro").read_text()
    file = tmp_path / "robot.urdf"
    file.write_text(text.replace("<robot ", '<robot xmlns="http://drake.mit.edu" ', 1))
    assert load_robot(file, FEET) == load_robot(path("astro"), FEET)


FEET = {"fl": "fl_foot", "fr": "fr_foot"}
DECLARED = re.compile(r"^.*?<robot", re.DOTALL)

ENCODINGS = {
    "gb2312": ('<?xml version="1.0" encoding="gb2312"?>\n<!-- 机器人 -->', "gb2312"),
    "latin-1": ("<?xml version='1.0' encoding='ISO-8859-1'?><!-- Lysø -->", "latin-1"),
    "windows": ('<?xml version="1.0" encoding="windows-1252"?><!-- “Lysø” -->', "cp1252"),
    "utf-16": ('<?xml version="1.0" encoding="utf-16"?><!-- Lysø -->', "utf-16"),
    "byte order mark": ('<?xml version="1.0" encoding="UTF-8"?><!-- Lysø -->', "utf-8-sig"),
    "no declaration": ("<!-- Lysø -->", "utf-8"),
    "blank lines": ('\n \t\n<?xml version="1.0"?>', "utf-8"),
    "comment": ('<!-- made by hand -->\n<!-- <?xml -->\n<?xml version="1.0" encoding="gbk"?><!-- 腿 -->', "gbk"),
}


@pytest.mark.parametrize("name", ENCODINGS)
def test_files_in_the_encodings_of_other_tools_are_read(name: str, tmp_path: Path) -> None:
    head, encoding = ENCODINGS[name]
    file = tmp_path / "robot.urdf"
    file.write_bytes(DECLARED.sub(head + "<robot", path("astro").read_text(), count=1).encode(encoding))
    assert load_robot(file, FEET) == load_robot(path("astro"), FEET)


@pytest.mark.parametrize(
    ("content", "sentence"),
    [
        (b'<?xml version="1.0" encoding="klingon"?><robot/>', "not text in the encoding 'klingon'"),
        (b'<?xml version="1.0" encoding="base64"?><robot/>', "not text in the encoding 'base64'"),
        (b'<?xml version="1.0" encoding="punycode"?><robot/>', "not an encoding of files"),
        ("<!-- Lysø --><robot/>".encode("latin-1"), "not text in the encoding 'utf-8-sig'"),
        (b"<!---->" * 500 + b"<?xml", "not well-formed XML"),
    ],
)
def test_other_bytes_are_refused(content: bytes, sentence: str, tmp_path: Path) -> None:
    (tmp_path / "robot.urdf").write_bytes(content)
    with pytest.raises(InputError, match=sentence) as caught:
        load(tmp_path / "robot.urdf")
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("number", ["6_0", "0x10", "٣", "1,5", "1e", "", "."])
def test_what_only_some_programs_read_is_no_number(number: str, tmp_path: Path) -> None:
    text = re.sub(r'<mass\s+value="[^"]+"', f'<mass value="{number}"', path("astro").read_text(), count=1)
    (tmp_path / "robot.urdf").write_text(text)
    with pytest.raises(InputError, match="not a number"):
        load_robot(tmp_path / "robot.urdf", FEET)


@pytest.mark.parametrize("number", ["1.", ".5", "+2e-1", " 1.5 ", "1E+0"])
def test_decimal_notations_are_numbers(number: str, tmp_path: Path) -> None:
    text = re.sub(r'<mass\s+value="[^"]+"', f'<mass value="{number}"', path("astro").read_text(), count=1)
    (tmp_path / "robot.urdf").write_text(text)
    assert load_robot(tmp_path / "robot.urdf", FEET).links[0].mass == float(number)


@pytest.mark.parametrize("kind", ["revolute", "fixed"])
def test_a_long_chain_from_its_end_is_linear_work(kind: str, tmp_path: Path) -> None:
    """5,000 links in reverse order took 24 s; 20,000 now take 3 s of processor time."""
    size = 5_000
    body = '<inertial><mass value="1"/><inertia ixx="1" ixy="0" ixz="0" iyy="1" iyz="0" izz="1"/></inertial>'
    parts = [f'<link name="l{n}">{body}</link>' for n in range(size + 1)]
    for n in range(1, size + 1):
        ends = f'<parent link="l{n - 1}"/><child link="l{n}"/>'
        parts.append(f'<joint name="j{n}" type="{kind if n > 1 else "revolute"}">{ends}</joint>')
    (tmp_path / "robot.urdf").write_text(f'<robot name="r">{"".join(reversed(parts))}</robot>')
    begun = time.process_time()
    if kind == "revolute":  # the file is walked, then the robot is refused
        with pytest.raises(InputError, match="has 5000 moving joints"):
            load_robot(tmp_path / "robot.urdf", {"a": f"l{size}"})
    else:
        assert load_robot(tmp_path / "robot.urdf", {"a": f"l{size}"}).mass == size + 1
    assert time.process_time() - begun < 10.0
