"""Robots from MJCF: against the accelerations of MuJoCo itself, and against the same robot from a URDF."""

from __future__ import annotations

import os
import random
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.robot import Adaptation, Robot, dynamics, kinematics, load_robot, mjcf_model
from amble.types import Vector
from benchmarks.robot_files import ALIENGO, FILES, MJCF, RobotFile
from fuzz.bytes import damaged
from tests.quadruped import FEET, urdf
from tests.robots import ROBOTS, random_states, robot
from tests.seeds import seeds

mujoco = pytest.importorskip("mujoco")

HEAD = """<mujoco model="odd"><compiler angle="degree"/><option gravity="0 0 -9.81"/>
<default><joint armature="0.01" damping="0.2"/><default class="stiff"><joint damping="0.7"/></default></default>
<worldbody><geom type="plane" size="9 9 1"/><body name="trunk" pos="0 0 1" euler="10 20 30">{free}
<inertial pos="0.01 0 0" mass="5" fullinertia="0.05 0.08 0.1 0.001 0.002 0.003"/>"""
LEG = """<body name="{n}_hip" pos="{x} {y} 0" euler="0 0 15">
<joint name="{n}_yaw" axis="0 0 1" pos="0.01 0.02 0"/><joint name="{n}_pitch" axis="0 1 0" ref="25" range="-80 70"/>
<geom type="capsule" size="0.02" fromto="0 0 0 0.02 0 -0.2" mass="0.8"/>
<body name="{n}_shank" pos="0.02 0 -0.2"><joint name="{n}_knee" class="stiff" axis="0 1 0" pos="0 0.01 0.01"/>
<geom name="{n}_foot" type="sphere" size="0.02" pos="0.01 0 -0.2" mass="0.1"/>
<geom type="capsule" size="0.01" fromto="0 0 0 0 0 -0.18" mass="0.2"/></body></body>"""
LEGS = "".join(
    LEG.format(n=n, x=x, y=y)
    for n, x, y in (("fl", 0.2, 0.1), ("fr", 0.2, -0.1), ("rl", -0.2, 0.1), ("rr", -0.2, -0.1))
)
MOTORS = '<actuator><motor joint="fl_yaw" gear="2" ctrlrange="-3 4" ctrllimited="true"/></actuator>'
ODD_FEET = {label: f"{label}_foot" for label in ("fl", "fr", "rl", "rr")}


def odd(free: str = "<freejoint/>", more: str = MOTORS) -> str:
    return HEAD.format(free=free) + LEGS + f"</body></worldbody>{more}</mujoco>"


def quaternion(rotation: np.ndarray) -> Vector:
    found = np.zeros(4)
    mujoco.mju_mat2Quat(found, np.ascontiguousarray(rotation).ravel())
    return found


def accelerations_agree(walker: Robot, model: object, tolerance: float = 1e-10) -> None:
    """Torques on a flying robot: accelerations of joints, of the base's origin and its angular velocity.

    Relative to their size; both solve a linear system of 18 unknowns in double precision.
    """
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_CONTACT)  # type: ignore[attr-defined]
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_LIMIT)  # type: ignore[attr-defined]
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_ACTUATION)  # type: ignore[attr-defined]
    data, generator = mujoco.MjData(model), np.random.default_rng(0)
    q, v, a = (ca.SX.sym(letter, walker.size) for letter in "qva")
    spin = kinematics.angle_axes(q) @ v[3:6]
    turn = ca.Function("turn", [q, v, a], [ca.jtimes(spin, q, v) + ca.jtimes(spin, v, a)])
    hinges = [model.joint(name) for name in walker.joint_names]  # type: ignore[attr-defined]
    for pose, rate in zip(*random_states(walker, 3), strict=True):
        torque = generator.normal(size=len(hinges))
        data.qpos[:3], data.qvel[:3] = pose[:3], rate[:3]
        data.qpos[3:7] = quaternion(np.asarray(kinematics.base_rotation(pose)))
        data.qvel[3:6] = np.asarray(kinematics.angle_axes(pose)) @ rate[3:6]
        for hinge, angle, speed, u in zip(hinges, pose[6:], rate[6:], torque, strict=True):
            data.qpos[hinge.qposadr[0]], data.qvel[hinge.dofadr[0]] = angle, speed
            data.qfrc_applied[hinge.dofadr[0]] = u
        mujoco.mj_forward(model, data)
        force = np.concatenate([np.zeros(6), torque]) - np.asarray(dynamics.bias(walker, pose, rate)).ravel()
        ours = np.linalg.solve(np.asarray(dynamics.mass_matrix(walker, pose)), force)
        theirs = [data.qacc[:3], data.qacc[3:6], [data.qacc[hinge.dofadr[0]] for hinge in hinges]]
        mine = [ours[:3], np.asarray(turn(pose, rate, ours)).ravel(), ours[6:]]
        size = max(np.abs(np.concatenate(mine)).max(), 1.0)
        for one, other in zip(mine, theirs, strict=True):
            np.testing.assert_allclose(one, other, atol=tolerance * size, rtol=0.0)


def test_several_joints_a_body_their_places_references_and_defaults(tmp_path: Path) -> None:
    file = tmp_path / "odd.xml"
    file.write_text(odd())
    walker = load_robot(file, ODD_FEET)
    assert walker.name == "odd"
    assert walker.joint_names[:3] == ("fl_yaw", "fl_pitch", "fl_knee")
    accelerations_agree(walker, mujoco.MjModel.from_xml_path(str(file)))
    pitch = walker.joint("fl_pitch")
    assert (pitch.lower, pitch.upper) == pytest.approx(np.deg2rad([-80.0, 70.0]))
    assert (pitch.rotor_inertia, pitch.damping, walker.joint("fl_knee").damping) == (0.01, 0.2, 0.7)
    assert walker.joint("fl_yaw").effort == 8.0
    assert walker.joint("fl_pitch").effort == np.inf
    model = mujoco.MjModel.from_xml_path(str(file))
    data = mujoco.MjData(model)
    q = random_states(walker, 1)[0][0]
    data.qpos[:3], data.qpos[3:7] = q[:3], quaternion(np.asarray(kinematics.base_rotation(q)))
    for name, angle in zip(walker.joint_names, q[6:], strict=True):
        data.qpos[model.joint(name).qposadr[0]] = angle
    mujoco.mj_forward(model, data)
    for foot, geom in ODD_FEET.items():
        place = np.asarray(kinematics.foot_position(walker, foot, q)).ravel()
        np.testing.assert_allclose(place, data.geom(geom).xpos, atol=1e-13)


@pytest.mark.parametrize("name", ROBOTS)
def test_a_robot_written_as_mjcf_comes_back(name: str, tmp_path: Path) -> None:
    """Against what MuJoCo took: it balances the inertias of ASTRo's lower legs, which are those of no body."""
    from benchmarks.mujoco_model import model_of

    walker, file = robot(name), tmp_path / "robot.xml"
    file.write_text(model_of(walker).replace('<geom type="sphere"', '<geom type="sphere" mass="0"'))
    again = load_robot(file, {foot.name: walker.links[foot.link].name for foot in walker.feet})
    assert again.joint_names == walker.joint_names or set(again.joint_names) == set(walker.joint_names)
    accelerations_agree(again, mujoco.MjModel.from_xml_path(str(file)))
    assert again.mass == pytest.approx(walker.mass, rel=1e-9)


def test_the_same_robot_from_urdf_and_from_mujocos_own_translation(tmp_path: Path) -> None:
    """MuJoCo reads the URDF and writes MJCF, with numbers of about six digits."""
    file = tmp_path / "padda.urdf"
    file.write_text(urdf())
    plain = load_robot(file, FEET)
    spec = mujoco.MjSpec.from_file(str(file))
    spec.compiler.fusestatic = False
    next(body for body in spec.bodies if body.name == "trunk").add_freejoint()
    spec.compile()
    twin = tmp_path / "padda.mjcf"
    twin.write_text(spec.to_xml())
    walker = load_robot(twin, FEET)
    assert walker.joint_names == plain.joint_names
    for q, v in zip(*random_states(plain, 3), strict=True):
        for ours, theirs in (
            (dynamics.mass_matrix(walker, q), dynamics.mass_matrix(plain, q)),
            (dynamics.bias(walker, q, v), dynamics.bias(plain, q, v)),
            (kinematics.foot_position(walker, "fl", q), kinematics.foot_position(plain, "fl", q)),
        ):
            expected = np.asarray(theirs)
            np.testing.assert_allclose(np.asarray(ours), expected, atol=1e-5 * np.abs(expected).max(), rtol=0.0)


def test_what_cannot_be_read_is_said(tmp_path: Path) -> None:
    file = tmp_path / "odd.xml"
    for text, words in (
        (odd(free=""), "'trunk' is fixed to the world, a floating base is needed: give it a freejoint"),
        (odd(more='<equality><connect body1="fl_shank" body2="fr_shank" anchor="0 0 0"/></equality>'), "closes a loop"),
        ("<mujoco><worldbody/></mujoco>", "no body of the file moves on joints"),
        ("<mujoco><worldbody><nonsense/></worldbody></mujoco>", "MuJoCo does not compile it"),
        (odd(more='<equality><joint joint1="fl_knee" joint2="fr_knee"/></equality>'), "'fl_knee' mimics 'fr_knee'"),
    ):
        file.write_text(text)
        with pytest.raises(InputError, match=words) as caught:
            load_robot(file, ODD_FEET)
        assert "\n" not in str(caught.value)
    file.write_text(odd(more='<equality><joint joint1="fl_knee" joint2="fr_knee"/></equality>'))
    assert "fl_knee" not in load_robot(file, ODD_FEET, adaptation=Adaptation(locked={"fl_knee": 0.4})).joint_names
    file.write_text(urdf())  # a URDF that is called .xml
    assert load_robot(file, FEET).name == "padda"


@pytest.mark.parametrize("number", ["1e13", "1e200", "1e308"])
def test_numbers_that_no_robot_has_are_refused_before_they_are_multiplied(number: str, tmp_path: Path) -> None:
    file = tmp_path / "odd.xml"
    inertia = 'fullinertia="0.05 0.08 0.1 0.001 0.002 0.003"'
    assert inertia in odd()
    file.write_text(odd().replace(inertia, f'diaginertia="{number} {number} {number}"'))
    with np.errstate(all="raise"), pytest.raises(InputError, match=r"body_inertia of .* are finite, up to 1e"):
        load_robot(file, ODD_FEET)


def test_meshes_need_not_be_there_and_springs_are_named(tmp_path: Path) -> None:
    text = odd().replace("<worldbody>", '<asset><mesh name="body" file="nowhere.stl"/></asset><worldbody>', 1)
    text = text.replace('<inertial pos="0.01 0 0"', '<geom type="mesh" mesh="body"/><inertial pos="0.01 0 0"')
    file, plain = tmp_path / "mesh.xml", tmp_path / "odd.xml"
    file.write_text(text.replace('class="stiff" axis', 'class="stiff" stiffness="3" axis', 1))
    plain.write_text(odd())
    walker = load_robot(file, ODD_FEET)
    assert walker.hash == load_robot(plain, ODD_FEET).hash
    assert walker.unused == ("joint 'fl_knee' has a spring (stiffness 3), which is not used",)


INSIDE = "<mujoco><include file={!r}/>" + odd()[len('<mujoco model="odd">') :]
SOLID = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 1 4 3\n"
MESHED = odd().replace("<worldbody>", '<asset><mesh name="body" file="{}"/></asset><worldbody>', 1)
MESHED = MESHED.replace('<inertial pos="0.01 0 0" mass="5" fullinertia="0.05 0.08 0.1 0.001 0.002 0.003"/>', "{}")
"""The trunk's inertia is that of its mesh."""


def test_files_in_the_folder_are_read(tmp_path: Path) -> None:
    """An included part, one that it includes, and a mesh whose inertia counts."""
    (tmp_path / "parts").mkdir()
    file = tmp_path / "robot.xml"
    file.write_text(INSIDE.format("parts/motors.xml").replace(MOTORS, ""))
    (tmp_path / "parts" / "motors.xml").write_text('<mujoco><include file="more.xml"/></mujoco>')
    (tmp_path / "more.xml").write_text(f"<mujoco>{MOTORS}</mujoco>")
    assert load_robot(file, ODD_FEET).joint("fl_yaw").effort == 8.0
    (tmp_path / "meshes").mkdir()
    (tmp_path / "meshes" / "solid.obj").write_text(SOLID)
    compiler = 'angle="degree" meshdir="meshes"'
    file.write_text(MESHED.format("solid.obj", '<geom type="mesh" mesh="body"/>').replace('angle="degree"', compiler))
    assert load_robot(file, ODD_FEET).links[0].mass == pytest.approx(1000.0 / 6.0)


@pytest.mark.parametrize("kind", ["include", "model", "mesh", "link"])
def test_files_elsewhere_are_not_read(kind: str, tmp_path: Path) -> None:
    """A file could have MuJoCo open any other: what it held changed the robot in silence, or stood in the error."""
    folder, secret = tmp_path / "robot", tmp_path / "secret.obj"
    folder.mkdir()
    secret.write_text(SOLID)
    (folder / "link.obj").symlink_to(secret)
    text = {
        "include": INSIDE.format("../secret.obj"),
        "model": odd().replace("<worldbody>", f'<asset><model name="a" file="{secret}"/></asset><worldbody>', 1),
        "mesh": MESHED.format(secret, '<geom type="mesh" mesh="body"/>'),
        "link": MESHED.format("link.obj", '<geom type="mesh" mesh="body"/>'),
    }[kind]
    (folder / "robot.xml").write_text(text)
    with pytest.raises(InputError, match="outside its folder, which is not read"):
        load_robot(folder / "robot.xml", ODD_FEET)


def test_included_pipes_and_files_that_are_not_there(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.xml")
    file = tmp_path / "robot.xml"
    for name in ("pipe.xml", "nowhere.xml"):
        file.write_text(INSIDE.format(name))
        with pytest.raises(InputError, match="needs the file"):
            load_robot(file, ODD_FEET)


def test_a_file_under_many_names_is_counted_every_time(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """400 names of one file of 30 MB filled the memory."""
    monkeypatch.setattr(mjcf_model, "MOST_BYTES", 1000)
    (tmp_path / "part.xml").write_text(f"<mujoco><!--{'x' * 100}--></mujoco>")
    names = "".join(f'<include file="{"./" * count}part.xml"/>' for count in range(20))
    (tmp_path / "robot.xml").write_text(f"<mujoco>{names}</mujoco>")
    with pytest.raises(InputError, match="uses files of more than"):
        load_robot(tmp_path / "robot.xml", ODD_FEET)


@pytest.mark.slow
@pytest.mark.parametrize(
    "bomb",
    [
        '<replicate count="2000000000" offset="0 0 1"><geom size="0.1"/></replicate>',
        '<replicate count="3000" offset="0 0 1"><replicate count="3000" offset="0 1 0"><geom size="0.1"/></replicate>'
        "</replicate>",
    ],
)
def test_what_multiplies_ends_in_a_sentence(bomb: str, tmp_path: Path) -> None:
    file = tmp_path / "robot.xml"
    file.write_text(odd().replace("<worldbody>", f"<worldbody>{bomb}", 1))
    with pytest.raises(InputError) as caught:
        load_robot(file, ODD_FEET)
    assert str(caught.value).isprintable()


VALUES = (
    "1e400",
    "nan",
    "inf",
    "-1",
    "0 0 0",
    "1e308 1e308 1e308",
    "9" * 400,
    "mesh",
    "free",
    "ball",
    "fl_hip",
    "",
    "*/",
)


def damaged_mjcf(draw: random.Random) -> bytes:
    """One or two attributes of another value, or other bytes."""
    content = odd().encode()
    for _ in range(draw.choice((1, 1, 2))):
        at = draw.choice(list(re.finditer(rb'"[^"<>]*"', content)) or [None])
        if at is None or draw.random() < 0.3:
            content = damaged(content, draw)[0]
        else:
            content = content[: at.start()] + f'"{draw.choice(VALUES)}"'.encode() + content[at.end() :]
    return content


@pytest.mark.parametrize("seed", seeds(1, 20))
def test_a_damaged_file_is_a_robot_or_one_sentence(
    seed: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    """MuJoCo printed, and wrote a log file of its own into the working folder."""
    monkeypatch.chdir(tmp_path)
    draw, refused = random.Random(seed), 0
    for _ in range(6):
        Path("robot.xml").write_bytes(damaged_mjcf(draw))
        try:
            load_robot(Path("robot.xml"), ODD_FEET)
        except InputError as error:
            refused += 1
            assert str(error).isprintable()  # noqa: PT017 - most are refused, not all
    assert refused > 0
    assert os.listdir() == ["robot.xml"]
    assert capfd.readouterr() == ("", "")


@pytest.mark.parametrize(
    ("old", "new", "says"),
    [(b'mass="5"', b'mass="nan"', "MuJoCo"), (b'"fl_hip"', b'"\xccf"', "not well-formed XML")],
)
def test_what_mujoco_would_print_is_said_in_words(
    old: bytes, new: bytes, says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    content = odd().encode()
    assert old in content
    Path("robot.xml").write_bytes(content.replace(old, new))
    with pytest.raises(InputError, match=says):
        load_robot(Path("robot.xml"), ODD_FEET)
    assert os.listdir() == ["robot.xml"]


def described(name: str, kind: RobotFile) -> Robot:
    if kind.absent:
        pytest.skip(kind.absent)
    return load_robot(kind.place(), kind.feet, name=name, adaptation=Adaptation(dry_friction={"*": 0.0}))


@pytest.mark.parametrize("name", MJCF)
def test_published_mjcf_against_mujoco(name: str) -> None:
    """Rotors and damping are both's; dry friction is left out of both, a constraint there and smooth here."""
    walker = described(name, MJCF[name])
    model = mujoco.MjModel.from_xml_path(str(MJCF[name].place()))
    model.opt.disableflags |= int(mujoco.mjtDisableBit.mjDSBL_FRICTIONLOSS)
    model.opt.gravity[:] = (0.0, 0.0, -walker.gravity)
    assert all(joint.rotor_inertia > 0.0 and joint.damping > 0.0 for joint in walker.joints)
    accelerations_agree(walker, model)


@pytest.mark.parametrize("name", MJCF)
def test_published_mjcf_against_urdf(name: str) -> None:
    """The pairs tell two machines: other trunks and payloads, and rotors in one only, on the same joints and legs.

    With the bodies of the URDF on the joints of the MJCF file all accelerations are those of the URDF.
    """
    urdf = ALIENGO if name == "aliengo" else FILES[name]
    ours, theirs = described(name, MJCF[name]), described(name, urdf)
    place = {theirs.legs[foot][number]: joint for foot in ours.legs for number, joint in enumerate(ours.legs[foot])}
    joints = [ours.joint(place[joint.name]) for joint in theirs.joints]  # in the order of the URDF
    number = {ours.joint(place[joint.name]).child: joint.child for joint in theirs.joints} | {0: 0}
    same = replace(
        theirs,
        joints=tuple(
            replace(joint, parent=number[joint.parent], child=own.child, rotor_inertia=0.0, damping=0.0)
            for joint, own in zip(joints, theirs.joints, strict=True)
        ),
    )
    generator = np.random.default_rng(0)
    for q, v in zip(*random_states(theirs, 3), strict=True):
        force = np.concatenate([np.zeros(6), generator.normal(size=len(joints))])
        one, other = (
            np.linalg.solve(
                np.asarray(dynamics.mass_matrix(walker, q)), force - np.asarray(dynamics.bias(walker, q, v)).ravel()
            )
            for walker in (same, theirs)
        )
        np.testing.assert_allclose(one, other, atol=1e-10 * np.abs(other).max(), rtol=0.0)


@pytest.mark.parametrize("name", ["go2", "mini_cheetah", "aliengo", "vision60"])
def test_published_urdf_against_mujoco(name: str) -> None:
    """MuJoCo reads the URDF itself: the reader of MJCF and that of URDF agree with one engine."""
    file = ALIENGO if name == "aliengo" else FILES[name]
    walker = described(name, file)
    tree = ElementTree.parse(file.place())
    for link in tree.getroot().iter("link"):
        for shape in [part for part in link if part.tag in ("visual", "collision")]:
            link.remove(shape)
    ElementTree.SubElement(ElementTree.SubElement(tree.getroot(), "mujoco"), "compiler", {"fusestatic": "false"})
    spec = mujoco.MjSpec.from_string(ElementTree.tostring(tree.getroot()).decode())
    next(iter(spec.worldbody.bodies)).add_freejoint()
    model = spec.compile()
    model.opt.gravity[:] = (0.0, 0.0, -walker.gravity)
    model.dof_damping[:], model.dof_frictionloss[:] = 0.0, 0.0
    still = replace(walker, joints=tuple(replace(joint, damping=0.0) for joint in walker.joints))
    accelerations_agree(still, model)


@pytest.mark.parametrize("name", ["loop.obj", "n" * 300 + ".obj"])
def test_a_mesh_that_leads_nowhere_is_a_sentence(name: str, tmp_path: Path) -> None:
    (tmp_path / "loop.obj").symlink_to("loop.obj")
    (tmp_path / "robot.xml").write_text(MESHED.format(name, '<geom type="mesh" mesh="body"/>'))
    with pytest.raises(InputError, match="which is not there"):
        load_robot(tmp_path / "robot.xml", ODD_FEET)
