"""Rotors, damping and dry friction of joints, against MuJoCo's armature and damping, and against their own laws."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from amble.errors import InputError
from amble.robot import Adaptation, Robot, dynamics, load_robot, symmetrized
from tests.quadruped import FEET, write
from tests.robots import random_states, robot

SAID = '<dynamics damping="0.4" friction="0.3"/>'
TRANSMISSIONS = "".join(
    f'<transmission name="{leg}_{part}"><joint name="{leg}_{part}"/><actuator name="m"><mechanicalReduction>9'
    "</mechanicalReduction><motorInertia>1e-4</motorInertia></actuator></transmission>"
    for leg in ("lf", "rf", "lh", "rh")
    for part in ("hx", "hy", "kn")
)


def adapted(file: Path, **change: object) -> Robot:
    return load_robot(file, FEET, adaptation=Adaptation(**change))  # type: ignore[arg-type]


def test_what_a_file_says_of_its_drives_is_used(tmp_path: Path) -> None:
    """Both robots were equal, hash and all; the rotor is several times the knee's own inertia."""
    plain, driven = load_robot(write(tmp_path), FEET), load_robot(write(tmp_path, TRANSMISSIONS, SAID), FEET)
    assert plain.hash != driven.hash
    assert driven.unused == ()
    q, v = (states[0] for states in random_states(plain, 1))
    gained = np.asarray(dynamics.mass_matrix(driven, q)) - np.asarray(dynamics.mass_matrix(plain, q))
    np.testing.assert_allclose(np.diag(gained), [0.0] * 6 + [81e-4] * 12, atol=1e-15)
    width = driven.joints[0].friction_width
    lost = np.asarray(dynamics.bias(driven, q, v) - dynamics.bias(plain, q, v)).ravel()
    np.testing.assert_allclose(lost[:6], 0.0, atol=1e-15)
    np.testing.assert_allclose(lost[6:], 0.4 * v[6:] + 0.3 * np.tanh(v[6:] / width), rtol=1e-12)
    energy = float(dynamics.kinetic_energy(driven, q, v)) - float(dynamics.kinetic_energy(plain, q, v))
    assert energy == pytest.approx(0.5 * 81e-4 * v[6:] @ v[6:], rel=1e-9)
    assert adapted(write(tmp_path, TRANSMISSIONS, SAID), file_drives=False).hash == plain.hash


def test_overlays_take_the_place_of_the_file(tmp_path: Path) -> None:
    driven = adapted(
        write(tmp_path, TRANSMISSIONS, SAID),
        damping={"*": 0.0, "lf_kn": 1.0},
        dry_friction={"*": 0.0},
        friction_width=0.5,
    )
    assert [joint.damping for joint in driven.joints] == [1.0 if j == 2 else 0.0 for j in range(12)]
    assert all(joint.dry_friction == 0.0 == joint.friction_width for joint in driven.joints)
    assert all(joint.rotor_inertia == pytest.approx(81e-4) for joint in driven.joints)
    for change, words in (
        ({"damping": {"lf_knee": 1.0}}, "'lf_knee'"),
        ({"damping": {"*": -1.0}}, "damping of joint 'lf_hx' is -1"),
        ({"friction_width": -1.0}, "width of the dry friction is -1 rad/s"),
    ):
        with pytest.raises(InputError, match=words):
            adapted(write(tmp_path, TRANSMISSIONS, SAID), **change)


def test_accelerations_are_those_of_mujoco(tmp_path: Path) -> None:
    """The same drives in MuJoCo on a base at rest: M qacc + qfrc_bias - qfrc_passive = qfrc_applied, no friction."""
    mujoco = pytest.importorskip("mujoco")
    file = write(tmp_path, TRANSMISSIONS, '<dynamics damping="0.4"/>')
    walker = load_robot(file, FEET)
    spec = mujoco.MjSpec.from_string(file.read_text())
    spec.compiler.fusestatic = False
    for joint in spec.joints:
        if joint.type == mujoco.mjtJoint.mjJNT_HINGE:
            joint.armature, joint.damping = 81e-4, [0.4, 0.0, 0.0]
    model = spec.compile()
    data = mujoco.MjData(model)
    hinges = [model.joint(name) for name in walker.joint_names]
    for q, v in zip(*random_states(walker, 3), strict=True):
        data.qpos[:] = 0.0
        for joint, angle, rate in zip(hinges, q[6:], v[6:], strict=True):
            data.qpos[joint.qposadr[0]], data.qvel[joint.dofadr[0]] = angle, rate
        mujoco.mj_forward(model, data)
        dense = np.zeros((model.nv, model.nv))
        mujoco.mj_fullM(model, data, dense)
        places = [joint.dofadr[0] for joint in hinges]
        still = np.concatenate([np.zeros(6), q[6:]])
        rates = np.concatenate([np.zeros(6), v[6:]])
        ours = np.asarray(dynamics.mass_matrix(walker, still))[6:, 6:]
        np.testing.assert_allclose(ours, dense[np.ix_(places, places)], atol=1e-12)
        theirs = (data.qfrc_bias - data.qfrc_passive)[places]
        np.testing.assert_allclose(np.asarray(dynamics.bias(walker, still, rates)).ravel()[6:], theirs, atol=1e-10)


def test_left_and_right_drives_are_averaged(tmp_path: Path) -> None:
    driven = adapted(write(tmp_path), rotor_inertia={"lf_kn": 0.02, "rf_kn": 0.04})
    even = symmetrized(driven)
    assert even.joint("lf_kn").rotor_inertia == even.joint("rf_kn").rotor_inertia == pytest.approx(0.03)
    assert even.mirror.asymmetry < 1e-14


def test_the_work_of_the_torques_is_energy_gained_and_lost(tmp_path: Path) -> None:
    """Power of the generalised forces = dE/dt + damping and friction losses, along any smooth motion."""
    import casadi as ca

    driven = load_robot(write(tmp_path, TRANSMISSIONS, SAID), FEET)
    generator = np.random.default_rng(3)
    a, b, c = 0.3 * generator.normal(size=(3, driven.size))
    t = ca.SX.sym("t")
    q = a + b * t + c * t**2
    v, acceleration = b + 2 * c * t, ca.DM(2 * c)
    force = dynamics.inverse_dynamics(driven, q, v, acceleration)
    energy = dynamics.kinetic_energy(driven, q, v) + dynamics.potential_energy(driven, q)
    joints = v[6:]
    loss = 0.4 * ca.sumsqr(joints) + ca.dot(joints, 0.3 * ca.tanh(joints / driven.joints[0].friction_width))
    balance = ca.Function("balance", [t], [ca.dot(force, v) - ca.jacobian(energy, t) - loss, ca.dot(force, v)])
    for moment in (0.0, 0.4, 1.0):
        difference, power = (float(value) for value in balance(moment))
        assert abs(difference) < 1e-11 * max(abs(power), 1.0)


def test_astro_may_have_its_rotors() -> None:
    """The motors' rotors, which the paper leaves out: 3.4e-4 kg m^2 behind 37.2:1 (RMD-X8-Pro-H and a gear of 6:1)."""
    from amble.robot import catalogue

    plain = robot("astro")
    driven = catalogue.astro(Adaptation(rotor_inertia={"*": 3.4e-4 * 37.2**2}))
    assert driven.hash != plain.hash
    assert driven.mirror.asymmetry < 1e-9
