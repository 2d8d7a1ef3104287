"""The same robot in MuJoCo: accelerations agree to roundoff, also where inertias are none that a body can have."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.robot import dynamics
from amble.validation.mujoco_model import Plant, mujoco_model, to_mujoco
from tests.robots import random_states, robot

mujoco = pytest.importorskip("mujoco")


@pytest.mark.parametrize("name", ["astro", "go2", "anymal_b"])
def test_accelerations_agree_with_mujoco(name: str) -> None:
    """In the air, at random states and torques: our mass matrix and bias against MuJoCo's own recursion.

    Base rotations enter as rates of angles here and as a body rate there, so joints and the base's place are compared.
    """
    walker = robot(name)
    model = mujoco_model(walker, Plant(step=5e-4))
    data, generator = mujoco.MjData(model), np.random.default_rng(1)
    q, v = ca.SX.sym("q", walker.size), ca.SX.sym("v", walker.size)
    terms = ca.Function("terms", [q, v], [ca.densify(dynamics.mass_matrix(walker, q)), dynamics.bias(walker, q, v)])
    for place, rate in zip(*random_states(walker, 5), strict=True):
        place[2] = 10.0
        torque = generator.normal(0.0, 10.0, len(walker.joints))
        mass, bias = (np.asarray(part) for part in terms(place, rate))
        ours = np.linalg.solve(mass, np.concatenate([np.zeros(6), torque]) - bias.ravel())
        data.qpos[:], data.qvel[:] = to_mujoco(walker, model, place, rate)
        for joint, value in zip(walker.joint_names, torque, strict=True):
            data.ctrl[model.actuator(joint).id] = value
        mujoco.mj_forward(model, data)
        theirs = [data.qacc[model.joint(joint).dofadr[0]] for joint in walker.joint_names]
        scale = np.abs(ours).max()
        np.testing.assert_allclose(theirs, ours[6:], atol=1e-10 * scale)
        np.testing.assert_allclose(data.qacc[:3], ours[:3], atol=1e-10 * scale)


def test_the_plant_is_what_was_asked_for() -> None:
    walker = robot("astro")
    plant = Plant(step=1e-3, friction=0.5, radius=0.02, damping=0.3, dry_friction=0.4, armature=0.05, trunk=1.1)
    model = mujoco_model(walker, plant)
    assert model.opt.timestep == 1e-3
    np.testing.assert_allclose(model.dof_damping[6:], 0.3)
    np.testing.assert_allclose(model.dof_frictionloss[6:], 0.4)
    np.testing.assert_allclose(model.dof_armature[6:], 0.05)
    assert model.body(walker.links[0].name).mass[0] == pytest.approx(1.1 * walker.links[0].mass, rel=1e-12)
    assert sum(model.body(link.name).mass[0] for link in walker.links[1:]) == pytest.approx(
        sum(link.mass for link in walker.links[1:]), rel=1e-12
    )
    for foot in walker.foot_names:
        assert model.geom(foot).size[0] == 0.02
        pair = model.pair(f"{foot} on ground")
        np.testing.assert_array_equal(pair.friction[:2], 0.5)
        assert {model.geom(pair.geom1[0]).name, model.geom(pair.geom2[0]).name} == {"ground", foot}


@pytest.mark.parametrize(
    ("softness", "normal", "friction"), [(2e-3, 2e-3, 2e-3), (0.02, 0.02, 2e-3), (1e-4, 1e-3, 1e-3)]
)
def test_soft_contacts_are_soft_along_the_normal_only(softness: float, normal: float, friction: float) -> None:
    """No time constant below two steps, which MuJoCo cannot integrate."""
    model = mujoco_model(robot("astro"), Plant(step=5e-4, softness=softness))
    np.testing.assert_array_equal(model.pair_solref[:, 0], normal)
    np.testing.assert_array_equal(model.pair_solreffriction[:, 0], friction)
