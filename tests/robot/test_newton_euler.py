"""Regrouped parameters: the base carries all mass, and no motion can tell the difference."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.robot import dynamics, kinematics
from amble.robot.newton_euler import base_inertial_parameters
from amble.types import Matrix
from tests.robot.sampling import relative_error, sampled
from tests.robots import FOREIGN, ROBOTS, random_states, robot


@pytest.mark.parametrize("name", [*ROBOTS, *FOREIGN])
def test_the_base_carries_all_mass(name: str) -> None:
    model = robot(name)
    base, *others = base_inertial_parameters(model)
    assert base.mass == pytest.approx(model.mass, rel=1e-14)
    for body, joint in zip(others, model.joints, strict=True):
        assert abs(body.mass) < 1e-14 * model.mass
        assert abs(joint.axis @ body.first_moment) < 1e-14
        np.testing.assert_allclose(body.inertia, body.inertia.T, atol=1e-15)


@pytest.mark.parametrize("name", [*ROBOTS, *FOREIGN])
def test_kinetic_energy_is_that_of_the_links_as_they_are(name: str) -> None:
    """1/2 m c'.c' + 1/2 w.I w summed over the links of the file, velocities by derivatives of their poses."""
    model = robot(name)
    q, v = random_states(model, 10, seed=11)

    def by_links(q: ca.SX, v: ca.SX) -> ca.SX:
        energy = ca.SX(0)
        for i, link in enumerate(model.links):
            rotation, origin = kinematics.link_pose(model, i, q)
            velocity = ca.jtimes(origin + rotation @ link.center, q, v)
            turning = rotation.T @ ca.reshape(ca.jtimes(ca.vec(rotation), q, v), 3, 3)
            spin = ca.vertcat(turning[2, 1], turning[0, 2], turning[1, 0])
            energy += 0.5 * link.mass * ca.dot(velocity, velocity) + 0.5 * ca.bilin(ca.DM(link.inertia), spin, spin)
        return energy

    ours: Matrix = sampled(model, lambda q, v: dynamics.kinetic_energy(model, q, v), q, v)
    assert relative_error(ours, sampled(model, by_links, q, v)) < 1e-13  # a few hundred roundings
