"""Motion and forces by the numbers of a record, against the expressions that share nothing with them."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from flint import arb

from amble.proof.arithmetic import column, fraction, working_precision
from amble.proof.rigid_bodies import decimal, drive, motion, needed_forces, vector
from amble.robot import Robot, dynamics, kinematics
from amble.robot.base import SPATIAL
from amble.types import Vector
from tests import robots
from tests.sliding import sliding

ROUNDING = 1e-12
"""Of the expressions in floating point, relative to the largest force or length."""


def driven() -> Robot:
    """ASTRo with rotors, damping and dry friction."""
    astro = robots.robot("astro")
    joints = [
        replace(joint, rotor_inertia=0.01 * k, damping=0.2, dry_friction=0.3, friction_width=0.4)
        for k, joint in enumerate(astro.joints)
    ]
    return replace(astro, joints=tuple(joints))


def balls(robot: Robot, values: Vector) -> list[arb]:
    return [arb(float(value)) for value in np.asarray(robot.base.spatial(values))]


@pytest.mark.parametrize(
    "robot",
    [robots.robot("astro"), robots.robot("planar_biped"), robots.hexapod(), driven(), sliding(5)],
    ids=["astro", "planar", "hexapod", "driven", "sliding"],
)
def test_motions_and_forces_are_those_of_the_expressions(robot: Robot) -> None:
    """At random states, accelerations and contact forces at a foot."""
    draws = np.random.default_rng(0)
    states = zip(*robots.random_states(robot, 2), draws.normal(size=(2, robot.size)), strict=True)
    for q, v, a in states:
        foot, push = robot.feet[-1], draws.normal(size=3) * ([1, 1, 1] if robot.base.in_space else [1, 0, 1])
        with working_precision(170):
            at, rates, changes = (balls(robot, part) for part in (q, v, a))
            moving = motion(robot, at, rates, changes)
            place, velocity, acceleration = moving.links[foot.link].point(vector(foot.offset))
            pushes = {foot.link: [(place, column([arb(float(value)) for value in push]))]}
            needed = needed_forces(robot, moving, pushes, decimal(robot.gravity))
            for number, joint in enumerate(robot.joints, start=SPATIAL):
                needed[number] += drive(joint, rates[number], changes[number])
            found = np.array([float(needed[number]) for number in robot.base.columns(len(robot.joints))])
        J = np.asarray(kinematics.foot_jacobian(robot, foot.name, q))
        expected = np.asarray(dynamics.inverse_dynamics(robot, q, v, a)).ravel() - J.T @ push
        np.testing.assert_allclose(found, expected, atol=ROUNDING * np.abs(expected).max())
        bias = np.asarray(kinematics.foot_bias(robot, foot.name, q, v)).ravel()
        for part, other in (
            (place, np.asarray(kinematics.foot_position(robot, foot.name, q)).ravel()),
            (velocity, J @ v),
            (acceleration, J @ a + bias),
        ):
            assert [float(value) for value in part.entries()] == pytest.approx(other, abs=1e-11)


def test_numbers_are_the_decimals_of_the_file() -> None:
    with working_precision(170):
        assert not decimal(0.1).contains(arb(0.1))  # the double is another number
        for value in (0.1, 1e-7, 33.98, -4.5e16, 0.0):
            held, ball = Fraction(repr(value)), decimal(value)
            assert fraction(ball.lower()) <= held <= fraction(ball.upper())
