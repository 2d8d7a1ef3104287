"""Unilateral contact: one expression for every set of feet, against the equations of motion solved as they stand."""

from __future__ import annotations

from itertools import product

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import Contacts
from amble.hybrid.unilateral import STICKS, base_jacobian, normal_forces, unilateral_impact, unilateral_motion
from amble.robot import Robot, dynamics
from amble.robot.natural_units import velocity_unit
from amble.types import Vector
from tests.robots import random_states, robot

WALKER = robot("astro")
CONTACTS = Contacts(WALKER, WALKER.foot_names)


def terms(walker: Robot, place: Vector, rate: Vector) -> tuple[np.ndarray, ...]:
    """D, h, J, dJ/dt v and the Jacobian of the base's centre of mass."""
    q, v = ca.SX.sym("q", walker.size), ca.SX.sym("v", walker.size)
    parts = [dynamics.mass_matrix(walker, q), dynamics.bias(walker, q, v), CONTACTS.jacobian(q), CONTACTS.bias(q, v)]
    function = ca.Function("terms", [q, v], [ca.densify(part) for part in (*parts, base_jacobian(CONTACTS, q))])
    return tuple(np.asarray(part) for part in function(place, rate))


def test_the_motion_is_that_of_the_feet_in_contact() -> None:
    """The whole system [D -J'; J 0] of the feet in contact alone, solved by numpy, for every set of feet."""
    n, generator = WALKER.size, np.random.default_rng(3)
    symbols = [ca.SX.sym("a", 4), ca.SX.sym("q", n), ca.SX.sym("v", n), ca.SX.sym("u", n - 6), ca.SX.sym("f", 3)]
    motion = unilateral_motion(CONTACTS, *symbols)
    function = ca.Function("motion", symbols, [motion.acceleration, motion.forces])
    for active, place, rate in zip(product((0.0, 1.0), repeat=4), *random_states(WALKER, 16), strict=True):
        torque, push = generator.normal(0.0, 10.0, n - 6), generator.normal(0.0, 100.0, 3)
        D, h, J, bias, base = terms(WALKER, place, rate)
        rows = np.repeat(active, 3) > 0.5
        force = np.concatenate([np.zeros(6), torque]) - h.ravel() + base.T @ push
        whole = np.block([[D, -J[rows].T], [J[rows], np.zeros((rows.sum(), rows.sum()))]])
        expected = np.linalg.solve(whole, np.concatenate([force, -bias.ravel()[rows]]))
        found, forces = (np.asarray(part).ravel() for part in function(active, place, rate, torque, push))
        np.testing.assert_allclose(found, expected[:n], rtol=1e-8, atol=1e-8 * np.abs(expected[:n]).max())
        np.testing.assert_allclose(forces[rows], expected[n:], rtol=1e-7, atol=1e-7 * np.abs(forces).max())
        assert not forces[~rows].any()


@pytest.mark.parametrize("seed", range(20))
def test_an_impact_pushes_only(seed: int) -> None:
    """Feet in contact rest, D (v+ - v) = J' iota, no energy is won, and a foot that is left out is not pressed."""
    generator = np.random.default_rng(seed)
    (place,), (rate,) = random_states(WALKER, 1, seed=seed)
    landing = np.eye(4)[generator.integers(4)]
    active = np.maximum(landing, generator.integers(0, 2, 4))
    n = WALKER.size
    symbols = [ca.SX.sym("a", 4), ca.SX.sym("l", 4), ca.SX.sym("q", n), ca.SX.sym("v", n)]
    after, stands, impulses = unilateral_impact(CONTACTS, *symbols)
    normal = normal_forces(CONTACTS, impulses, CONTACTS.points(symbols[2]))
    function = ca.Function("impact", symbols, [after, stands, impulses, normal])
    v, a, impulse, pressed = (np.asarray(part).ravel() for part in function(active, landing, place, rate))
    D, _, J, _, _ = terms(WALKER, place, rate)
    rows = np.repeat(a, 3) > 0.5
    scale = np.abs(v).max()
    np.testing.assert_allclose(J[rows] @ v, 0.0, atol=1e-9 * scale)
    np.testing.assert_allclose(D @ (v - rate), J.T @ impulse, atol=1e-8 * np.abs(D @ rate).max())
    assert v @ D @ v <= rate @ D @ rate * (1.0 + 1e-12)
    assert np.all(a <= active)
    assert np.all(a >= landing)
    assert not impulse[~rows].any()
    kept = (a > 0.5) & (landing < 0.5)
    dropped = int(np.sum(active - a))
    assert dropped == 2 or np.all(pressed[kept] >= -STICKS * WALKER.mass * velocity_unit(WALKER))


def test_some_of_these_impacts_leave_a_foot_out() -> None:
    """Else the test above would not see the rule."""
    n, count = WALKER.size, 0
    symbols = [ca.SX.sym("a", 4), ca.SX.sym("l", 4), ca.SX.sym("q", n), ca.SX.sym("v", n)]
    function = ca.Function("impact", symbols, [unilateral_impact(CONTACTS, *symbols)[1]])
    for place, rate in zip(*random_states(WALKER, 20), strict=True):
        count += int(float(ca.sum1(function(np.ones(4), np.eye(4)[0], place, rate))) < 3.5)
    assert count > 5
