"""Joints that slide: random robots against Pinocchio, and what such joints are in files and words."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.robot import Adaptation, Robot, dynamics, kinematics, load_robot
from amble.robot.proposal import standing_posture
from amble.robot.symmetry import symmetrized
from amble.validation.mujoco_model import Plant, mujoco_model
from tests.oracle import Oracle
from tests.robot.sampling import relative_error, sampled, theirs
from tests.robots import random_states
from tests.sliding import FEET, LABELS, random_urdf, telescopic, telescopic_urdf

STATES = 30

# Both sides round at 1e-16 an operation over chains of some hundred operations.
TOLERANCE = 1e-12


@pytest.fixture(scope="module", params=range(4))
def pair(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> tuple[Robot, Oracle]:
    file: Path = tmp_path_factory.mktemp("sliding") / "robot.urdf"
    file.write_text(random_urdf(int(request.param)))
    model = load_robot(file, {label: f"{label}_foot" for label in LABELS}, twins=())
    assert any(joint.prismatic for joint in model.joints)
    assert not all(joint.prismatic for joint in model.joints)
    return model, Oracle(model, str(file))


def test_random_robots_move_as_pinocchio_says(pair: tuple[Robot, Oracle]) -> None:
    model, expected = pair
    q, v = random_states(model, STATES)
    a = 10.0 * random_states(model, STATES, seed=1)[1]
    ours = np.asarray(sampled(model, lambda q: dynamics.mass_matrix(model, q), q))
    assert relative_error(ours, theirs(expected.mass_matrix, q)) < TOLERANCE
    ours = sampled(model, lambda q, v: dynamics.bias(model, q, v), q, v)
    assert relative_error(ours, theirs(expected.bias, q, v)) < TOLERANCE
    ours = sampled(model, lambda q, v, a: dynamics.inverse_dynamics(model, q, v, a), q, v, a)
    assert relative_error(ours, theirs(expected.inverse_dynamics, q, v, a)) < TOLERANCE
    ours = sampled(model, lambda q, v: dynamics.kinetic_energy(model, q, v), q, v)
    assert relative_error(ours, theirs(expected.kinetic_energy, q, v)) < TOLERANCE
    ours = sampled(model, lambda q: dynamics.potential_energy(model, q), q)
    assert np.abs(ours - theirs(expected.potential_energy, q)).max() < TOLERANCE * model.mass * model.gravity
    ours = sampled(model, lambda q, v: ca.vertcat(*dynamics.momentum(model, q, v)), q, v)
    assert relative_error(ours, theirs(expected.momentum, q, v)) < TOLERANCE


def test_feet_of_random_robots_move_as_pinocchio_says(pair: tuple[Robot, Oracle]) -> None:
    model, expected = pair
    q, v = random_states(model, STATES, seed=2)

    def stacked(of: object, *states: ca.SX) -> ca.SX:
        return ca.vertcat(*[of(model, foot, *states) for foot in model.foot_names])  # type: ignore[operator]

    ours = sampled(model, lambda q: stacked(kinematics.foot_position, q), q)
    np.testing.assert_allclose(ours, theirs(lambda q: expected.positions(q).T, q), atol=1e-13)
    ours = np.asarray(sampled(model, lambda q: stacked(kinematics.foot_jacobian, q), q))
    assert relative_error(ours, theirs(expected.jacobian, q)) < TOLERANCE
    ours = sampled(model, lambda q, v: stacked(kinematics.foot_bias, q, v), q, v)
    assert relative_error(ours, theirs(expected.jacobian_bias, q, v)) < TOLERANCE


def test_the_mirror_of_what_slides() -> None:
    """Left and right slide alike where they turn the other way."""
    model = telescopic()
    assert model.mirror.asymmetry < 1e-14
    assert list(model.mirror.joints.sign[:3]) == [-1.0, 1.0, 1.0]
    heavier = replace(model.links[1], mass=1.001 * model.links[1].mass)
    uneven = replace(model, links=(model.links[0], heavier, *model.links[2:]))
    assert symmetrized(uneven).mirror.asymmetry < 1e-14


def test_the_same_robot_from_mujocos_translation(tmp_path: Path) -> None:
    """MuJoCo reads the URDF and writes MJCF, with numbers of about six digits; accelerations of it are MuJoCo's."""
    mujoco = pytest.importorskip("mujoco")
    from tests.robot.test_mjcf import accelerations_agree

    file = tmp_path / "telescopic.urdf"
    file.write_text(telescopic_urdf())
    spec = mujoco.MjSpec.from_file(str(file))
    spec.compiler.fusestatic = False
    next(body for body in spec.bodies if body.name == "trunk").add_freejoint()
    spec.compile()
    twin = tmp_path / "telescopic.mjcf"
    twin.write_text(spec.to_xml())
    walker, plain = load_robot(twin, FEET), telescopic()
    assert [joint.prismatic for joint in walker.joints] == [joint.prismatic for joint in plain.joints]
    assert [joint.upper for joint in walker.joints] == pytest.approx([joint.upper for joint in plain.joints])
    accelerations_agree(walker, mujoco.MjModel.from_xml_path(str(twin)))
    accelerations_agree(plain, mujoco_model(plain, Plant(step=1e-3)))


def test_a_leg_stands_in_the_middle_of_what_slides() -> None:
    model = telescopic()
    posture = standing_posture(model)
    assert posture.angles["fl_slide"] == pytest.approx(0.08)
    q = posture.coordinates(model)
    for foot in model.foot_names:
        hip, end = (
            np.asarray(place).ravel()
            for place in (
                kinematics.link_pose(model, model.joint(f"{foot}_pitch").child, q)[1],
                kinematics.foot_position(model, foot, q),
            )
        )
        assert end[0] == pytest.approx(hip[0], abs=1e-12)
        assert end[2] == pytest.approx(0.0, abs=1e-12)
    assert model.leg_length == pytest.approx(np.hypot(0.19, 0.1) + 0.05 + 0.26 + 0.18)  # stretched


def test_what_drives_a_joint_that_slides(tmp_path: Path) -> None:
    """A mass, N s/m and N; what holds for all joints holds for those that turn."""
    file = tmp_path / "telescopic.urdf"
    file.write_text(telescopic_urdf())
    change = Adaptation(
        rotor_inertia={"*": 0.01, "fl_slide": 2.0}, damping={"fl_slide": 30.0}, dry_friction={"*": 0.5, "fl_slide": 4.0}
    )
    model, bare = load_robot(file, FEET, adaptation=change), telescopic()
    slide, other = model.joint("fl_slide"), model.joint("fr_slide")
    assert (slide.rotor_inertia, slide.damping, slide.dry_friction) == (2.0, 30.0, 4.0)
    assert (other.rotor_inertia, other.dry_friction, model.joint("fr_roll").dry_friction) == (0.0, 0.0, 0.5)
    assert slide.friction_width == pytest.approx(model.joint("fl_roll").friction_width * model.leg_length)
    place, (q, v) = model.coordinate_index("fl_slide"), random_states(model, 1)
    added = np.asarray(dynamics.mass_matrix(model, q[0])) - np.asarray(dynamics.mass_matrix(bare, q[0]))
    assert added[place, place] == pytest.approx(2.0)
    taken = np.asarray(dynamics.bias(model, q[0], v[0])) - np.asarray(dynamics.bias(bare, q[0], v[0]))
    rate = v[0, place]
    assert taken[place, 0] == pytest.approx(30.0 * rate + 4.0 * np.tanh(rate / slide.friction_width))


def test_a_robot_of_the_plane_slides_in_it(tmp_path: Path) -> None:
    file = tmp_path / "telescopic.urdf"
    file.write_text(telescopic_urdf())
    hips = {f"{label}_roll": 0.0 for label in LABELS}
    model = load_robot(file, FEET, adaptation=Adaptation(planar=True, locked=hips))
    assert model.joint_names[:2] == ("fl_pitch", "fl_slide")
    file.write_text(telescopic_urdf().replace('<axis xyz="0 0 -1"/>', '<axis xyz="0 1 0"/>', 1))
    with pytest.raises(InputError, match=r"'fl_slide' slides along \(0, 1, 0\), not across y"):
        load_robot(file, FEET, adaptation=Adaptation(planar=True, locked=hips))
