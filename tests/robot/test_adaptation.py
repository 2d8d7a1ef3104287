"""Adapting a file's robot: against the same robot written by hand, and a remedy for what cannot be."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError, UnknownNameError
from amble.gait.files import load_gait, save_gait
from amble.robot import Adaptation, Payload, Robot, dynamics, kinematics, load_robot
from amble.robot.files import ROBOT
from amble.robot.proposal import standing_posture
from amble.robot.rotation import rotation_of_rpy
from amble.robot.sole import lowered
from amble.synthesis.specification import specification_of
from amble.synthesis.specified import robot_of
from amble.types import frozen
from tests.quadruped import FEET, inertial, joint, urdf, write
from tests.robots import random_states

HEAD = f'<link name="neck">{inertial(0.3, "0.01 0 0.02", "4e-4 4e-4 4e-4")}</link>' + joint(
    "pan", "trunk", "neck", "0.25 0 0.08", "0 0 1"
)
EAR = f'<link name="ear">{inertial(0.02, "0 0 0.01", "1e-6 1e-6 1e-6")}</link>' + joint(
    "tilt", "neck", "ear", "0 0 0.05", "0 1 0", '<mimic joint="pan" multiplier="0.5" offset="0.1"/>'
)


def adapted(file: Path, **change: object) -> Robot:
    return load_robot(file, FEET, adaptation=Adaptation(**change))  # type: ignore[arg-type]


def test_the_same_in_a_specification(tmp_path: Path) -> None:
    write(tmp_path, HEAD)
    tree = {
        "robot": {
            "file": "padda.urdf",
            "feet": FEET,
            "locked": {"pan": "10 deg"},
            "base": "trunk",
            "foot_offsets": {"fl": ["1 mm", 0.0, 0.0]},
            "payload": {"mass": "500 g", "position": [0.0, 0.0, "5 cm"]},
            "rotor_inertia": 0.01,
            "rotor_inertias": {"lf_kn": 0.02},
            "damping": "0.1 N m s/rad",
            "dry_frictions": {"lf_hx": "0.2 N m"},
            "friction_width": 0.3,
        },
        "gait": {"name": "trot", "speed": 0.3},
    }
    said = robot_of(specification_of(tree, "spec.toml").robot, tmp_path)
    meant = adapted(
        tmp_path / "padda.urdf",
        locked={"pan": np.deg2rad(10.0)},
        base="trunk",
        foot_offsets={"fl": frozen([1e-3, 0.0, 0.0])},
        payload=Payload(mass=0.5, position=frozen([0.0, 0.0, 0.05]), link="base"),
        rotor_inertia={"*": 0.01, "lf_kn": 0.02},
        damping={"*": 0.1},
        dry_friction={"lf_hx": 0.2},
        friction_width=0.3,
    )
    assert said.hash == meant.hash
    tree["robot"]["locked"] = {"pan": "1 kg"}  # type: ignore[index]
    with pytest.raises(InputError, match=r"'robot.locked.pan': .*unknown unit 'kg'"):
        specification_of(tree, "spec.toml")


def same_motion(one: Robot, other: Robot, tolerance: float = 1e-13) -> None:
    """D and h of both at random states, relative to their size."""
    for q, v in zip(*random_states(one, 3), strict=True):
        for ours, theirs in (
            (dynamics.mass_matrix(one, q), dynamics.mass_matrix(other, q)),
            (dynamics.bias(one, q, v), dynamics.bias(other, q, v)),
        ):
            np.testing.assert_allclose(
                np.asarray(ours), np.asarray(theirs), rtol=0.0, atol=tolerance * float(np.abs(np.asarray(theirs)).max())
            )


def test_a_locked_joint_is_a_fixed_one_turned_by_its_angle(tmp_path: Path) -> None:
    locked = adapted(write(tmp_path, HEAD), locked={"pan": 0.3})
    fixed = HEAD.replace('type="revolute"', 'type="fixed"').replace(
        '<origin xyz="0.25 0 0.08"/>', '<origin xyz="0.25 0 0.08" rpy="0 0 0.3"/>'
    )
    same_motion(locked, load_robot(write(tmp_path, fixed), FEET))
    assert "pan" not in locked.joint_names
    assert locked.locked_joints == {"pan": 0.3}
    free = load_robot(write(tmp_path, HEAD), FEET)
    assert "pan" in free.joint_names
    assert locked.hash != free.hash


def test_what_mimics_a_locked_joint_is_held_with_it(tmp_path: Path) -> None:
    file = write(tmp_path, HEAD + EAR)
    same_motion(adapted(file, locked={"pan": 0.3}), adapted(file, locked={"pan": 0.3, "tilt": 0.25}))
    with pytest.raises(InputError, match=r"'tilt' mimics 'pan', .*locked = { tilt = 0.0 } in \[robot\]"):
        load_robot(file, FEET)


def test_a_locked_prismatic_joint_is_held_at_a_place(tmp_path: Path) -> None:
    mast = HEAD.replace('type="revolute"', 'type="prismatic"')
    raised = HEAD.replace('type="revolute"', 'type="fixed"').replace("0.25 0 0.08", "0.25 0 0.18")
    same_motion(
        adapted(write(tmp_path, mast), locked={"pan": 0.1}), load_robot(write(tmp_path, raised), FEET), tolerance=1e-13
    )
    assert load_robot(write(tmp_path, mast), FEET).joint("pan").prismatic


def test_a_joint_of_another_kind_can_be_held_only_where_it_is(tmp_path: Path) -> None:
    file = write(tmp_path, HEAD.replace('type="revolute"', 'type="floating"'))
    with pytest.raises(InputError, match=r"only floating joint allowed .*locked = { pan = 0.0 }"):
        load_robot(file, FEET)
    fixed = write(tmp_path / "..", HEAD.replace('type="revolute"', 'type="fixed"'))
    same_motion(adapted(file, locked={"pan": 0.0}), load_robot(fixed, FEET))
    with pytest.raises(InputError, match="'pan' is floating, which can be locked only at 0"):
        adapted(file, locked={"pan": 1.0})
    with pytest.raises(UnknownNameError, match=r"joint to lock .*'pam'; known: .*pan"):
        adapted(file, locked={"pam": 1.0})


@pytest.mark.parametrize("angles", [(0.0, -np.pi / 2, 0.0), (np.pi / 2, 0.0, 0.0), (0.3, -0.2, 2.0)])
def test_a_base_that_is_mounted_otherwise_is_turned(angles: tuple[float, float, float], tmp_path: Path) -> None:
    """The root is turned against the trunk, as in files with y up or z forward; base_rotation undoes that."""
    rpy = " ".join(map(repr, angles))
    root = (
        '<link name="chassis"/><joint name="mount" type="fixed"><parent link="chassis"/><child link="trunk"/>'
        f'<origin rpy="{rpy}"/></joint>'
    )
    plain, file = load_robot(write(tmp_path), FEET), write(tmp_path / "..", root)
    same_motion(adapted(file, base_rotation=angles), plain)
    same_motion(adapted(file, base="trunk"), plain)
    seen, zero = load_robot(file, FEET), np.zeros(18)
    for foot in FEET:
        place = np.asarray(kinematics.foot_position(seen, foot, zero)).ravel()
        meant = np.asarray(kinematics.foot_position(plain, foot, zero)).ravel()
        np.testing.assert_allclose(place, rotation_of_rpy(np.array(angles)) @ meant, atol=1e-15)


def test_another_link_of_the_base_may_be_its_frame(tmp_path: Path) -> None:
    """A frame at the tail: the same robot seen from there."""
    tail = '<link name="tail"/>' + joint("end", "trunk", "tail", "-0.3 0 0.1", "1 0 0", kind="fixed")
    moved = adapted(write(tmp_path, tail), base="tail")
    plain = load_robot(write(tmp_path), FEET)
    q = random_states(plain, 1)[0][0]
    q[3:6] = 0.0
    shifted = q.copy()
    shifted[:3] += [-0.3, 0.0, 0.1]
    for foot in FEET:
        np.testing.assert_allclose(
            np.asarray(kinematics.foot_position(moved, foot, shifted)),
            np.asarray(kinematics.foot_position(plain, foot, q)),
            atol=1e-15,
        )
    with pytest.raises(InputError, match="'lf_shank' cannot be the base: joint 'lf_kn' moves it on"):
        adapted(write(tmp_path), base="lf_shank")


def virtual(*kinds: str) -> str:
    """A chain of joints without mass from a link 'world' to the trunk."""
    axes = {"prismatic": ["1 0 0", "0 1 0", "0 0 1"], "revolute": ["1 0 0", "0 1 0", "0 0 1"]}
    links, text = ["world", *(f"v{k}" for k in range(1, len(kinds))), "trunk"], '<link name="world"/>'
    for number, kind in enumerate(kinds):
        text += f'<link name="{links[number + 1]}"/>' if number < len(kinds) - 1 else ""
        text += joint(f"virtual {number}", links[number], links[number + 1], "0 0 0", axes[kind][number % 3], kind=kind)
    return text


def test_six_virtual_joints_are_a_free_base(tmp_path: Path) -> None:
    file = write(tmp_path, virtual(*["prismatic"] * 3, *["revolute"] * 3))
    assert load_robot(file, FEET).hash == load_robot(write(tmp_path / ".."), FEET).hash


def test_a_virtual_base_in_the_plane_can_be_freed(tmp_path: Path) -> None:
    file = write(tmp_path, virtual("prismatic", "prismatic", "revolute"))
    with pytest.raises(InputError, match=r"another plane than that of x and z: .*base = \"trunk\" in \[robot\]"):
        load_robot(file, FEET)
    assert adapted(file, base="trunk").hash == load_robot(write(tmp_path / ".."), FEET).hash


def test_a_payload_is_a_point_mass_on_its_link(tmp_path: Path) -> None:
    position = np.array([0.05, 0.01, 0.12])
    plain = load_robot(write(tmp_path), FEET)
    loaded = adapted(write(tmp_path), payload=Payload(mass=2.0, position=frozen(position), link="base"))
    assert loaded.mass == pytest.approx(plain.mass + 2.0, rel=1e-14)
    for q, v in zip(*random_states(plain, 3), strict=True):
        arm = np.asarray(kinematics.base_rotation(q)) @ position
        gained = float(dynamics.potential_energy(loaded, q)) - float(dynamics.potential_energy(plain, q))
        assert gained == pytest.approx(2.0 * 9.81 * (q[2] + arm[2]), rel=1e-12)
        spin = np.asarray(kinematics.base_rotation(q)) @ np.asarray(kinematics.angle_axes(q)) @ v[3:6]
        speed = v[:3] + np.cross(spin, arm)
        gained = float(dynamics.kinetic_energy(loaded, q, v)) - float(dynamics.kinetic_energy(plain, q, v))
        assert gained == pytest.approx(speed @ speed, rel=1e-9)
    on_shank = adapted(write(tmp_path), payload=Payload(mass=0.1, position=frozen(np.zeros(3)), link="lf_foot"))
    assert on_shank.links[3].mass == pytest.approx(0.25)
    for payload, words in (
        (Payload(mass=-1.0, position=frozen(np.zeros(3)), link="base"), "mass of -1 kg; it must be positive"),
        (Payload(mass=1.0, position=frozen(np.zeros(3)), link="head"), "unknown link of the payload .*'head'"),
    ):
        with pytest.raises(InputError, match=words):
            adapted(write(tmp_path), payload=payload)


def test_feet_have_an_offset_and_a_radius(tmp_path: Path) -> None:
    plain = load_robot(write(tmp_path), FEET)
    moved = adapted(write(tmp_path), foot_offsets={"fl": frozen([0.01, 0.0, -0.02])})
    np.testing.assert_allclose(moved.foot("fl").offset, [0.01, 0.0, -0.22], atol=1e-16)
    np.testing.assert_array_equal(moved.foot("fr").offset, plain.foot("fr").offset)
    round_feet = lowered(plain, 0.025)
    q = standing_posture(plain).coordinates(plain)
    for foot in FEET:
        np.testing.assert_allclose(
            np.asarray(kinematics.foot_position(round_feet, foot, q)).ravel(),
            np.asarray(kinematics.foot_position(plain, foot, q)).ravel() - [0.0, 0.0, 0.025],
            atol=1e-15,
        )
    with pytest.raises(UnknownNameError, match=r"foot .*'paw'"):
        adapted(write(tmp_path), foot_offsets={"paw": frozen(np.zeros(3))})
    with pytest.raises(InputError, match="foot_radius is 3 m"):
        lowered(plain, 3.0)


@pytest.mark.parametrize("abad", ["", inertial(0.5, "0 0.02 0", "0 0 0"), inertial(0.5, "0 0 0", "0 0 -2.4e-35")])
def test_links_between_two_joints_need_no_mass_or_inertia(abad: str, tmp_path: Path) -> None:
    """What counts is the mass matrix: the thigh hangs on them."""
    walker = load_robot(write(tmp_path, abad=abad), FEET)
    for q in random_states(walker, 5)[0]:
        assert np.linalg.eigvalsh(np.asarray(dynamics.mass_matrix(walker, q)))[0] > 1e-5
    assert abad or walker.links[1].mass == 0.0


def test_flat_bodies_are_refused_in_space_with_the_remedy(tmp_path: Path) -> None:
    flat = urdf().replace('ixx="0.04"', 'ixx="0"').replace('izz="0.11"', 'izz="0"')
    for moments in ('ixx="0.0003"', 'ixx="0.00208"', 'ixx="0.000505"', 'izz="0.0003"', 'izz="0.00016"', 'izz="1e-05"'):
        flat = flat.replace(moments, f'{moments[:3]}="0"')
    for place in ("0.07", "0.06", "0.02"):
        flat = flat.replace(f" {place} ", " 0 ").replace(f" -{place} ", " 0 ").replace(f" {place}0", " 0")
    file = tmp_path / "flat.urdf"
    file.write_text(flat)
    with pytest.raises(InputError, match="makes a robot of the plane: planar = true in"):
        load_robot(file, FEET)


def test_overlays_are_in_the_hash_and_in_the_gait_file(tmp_path: Path) -> None:
    file = write(tmp_path, HEAD)
    change = Adaptation(
        locked={"pan": 0.3},
        payload=Payload(mass=2.0, position=frozen([0.0, 0.0, 0.1]), link="base"),
        rotor_inertia={"*": 0.01, "lf_kn": 0.02},
        damping={"*": 0.1},
        dry_friction={"lf_hx": 0.2},
    )
    robot = load_robot(file, FEET, adaptation=change)
    written = ROBOT.encode(robot, "robot")
    again = ROBOT.decode(written, "robot")
    assert again.hash == robot.hash
    assert (again.joints[2].rotor_inertia, again.joints[3].rotor_inertia) == (0.02, 0.01)
    assert again.joints[0].dry_friction == 0.2
    assert again.joints[0].friction_width == pytest.approx(0.05 * np.sqrt(9.81 / robot.leg_length))
    assert (again.locked_joints, again.payload.mass) == ({"pan": 0.3}, 2.0)
    written["overlays"]["rotors"]["lf_kn"]["damping"]["value"] = 0.2
    with pytest.raises(InputError, match="does not have the hash it was written with"):
        ROBOT.decode(written, "robot")
    written["overlays"]["rotors"]["nose"] = written["overlays"]["rotors"].pop("lf_kn")
    with pytest.raises(UnknownNameError, match="'nose'"):
        ROBOT.decode(written, "robot")


def test_a_file_of_the_first_day_is_written_with_empty_places(tmp_path: Path) -> None:
    gait = load_gait(Path(__file__).parents[1] / "data" / "format-3.json")
    assert ROBOT.encode(gait.robot, "robot")["overlays"] == {"locked_joints": {}, "rotors": {}, "payload": {}}
    save_gait(gait, tmp_path / "gait.json")
