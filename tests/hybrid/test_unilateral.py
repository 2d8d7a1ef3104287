"""Unilateral contact: one expression for every set of feet, against the equations of motion solved as they stand."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from itertools import product

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import Contacts
from amble.hybrid.unilateral import STICKS, base_jacobian, normal_forces, unilateral_impact, unilateral_motion
from amble.robot import dynamics
from amble.robot.natural_units import velocity_unit
from amble.types import Vector, frozen
from tests.robots import random_states, robot

WALKER = robot("astro")
CONTACTS = Contacts(WALKER, WALKER.foot_names)


@cache
def expressions() -> ca.Function:
    q, v = ca.SX.sym("q", WALKER.size), ca.SX.sym("v", WALKER.size)
    parts = [dynamics.mass_matrix(WALKER, q), dynamics.bias(WALKER, q, v), CONTACTS.jacobian(q), CONTACTS.bias(q, v)]
    return ca.Function("terms", [q, v], [ca.densify(part) for part in (*parts, base_jacobian(CONTACTS, q))])


def terms(place: Vector, rate: Vector) -> tuple[np.ndarray, ...]:
    """D, h, J, dJ/dt v and the Jacobian of the base's centre of mass."""
    return tuple(np.asarray(part) for part in expressions()(place, rate))


@cache
def impacts() -> ca.Function:
    """(feet in contact, landing, q, v) -> rates after, feet in contact after, impulses, normal impulses."""
    n = WALKER.size
    symbols = [ca.SX.sym(name, size) for name, size in zip("alqv", (4, 4, n, n), strict=True)]
    after, stands, impulses = unilateral_impact(CONTACTS, *[*symbols, ca.SX(0.0)])
    normal = normal_forces(CONTACTS, impulses, CONTACTS.points(symbols[2]))
    return ca.Function("impact", symbols, [after, stands, impulses, normal])


def test_the_motion_is_that_of_the_feet_in_contact() -> None:
    """The whole system [D -J'; J 0] of the feet in contact alone, solved by numpy, for every set of feet."""
    n, generator = WALKER.size, np.random.default_rng(3)
    symbols = [ca.SX.sym(name, size) for name, size in zip("aqvufe", (4, n, n, n - 6, 3, 1), strict=True)]
    motion = unilateral_motion(CONTACTS, *symbols)
    function = ca.Function("motion", symbols, [motion.acceleration, motion.forces])
    for active, place, rate in zip(product((0.0, 1.0), repeat=4), *random_states(WALKER, 16), strict=True):
        torque, push = generator.normal(0.0, 10.0, n - 6), generator.normal(0.0, 100.0, 3)
        D, h, J, bias, base = terms(place, rate)
        rows = np.repeat(active, 3) > 0.5
        force = np.concatenate([np.zeros(6), torque]) - h.ravel() + base.T @ push
        whole = np.block([[D, -J[rows].T], [J[rows], np.zeros((rows.sum(), rows.sum()))]])
        expected = np.linalg.solve(whole, np.concatenate([force, -bias.ravel()[rows]]))
        found, forces = (np.asarray(part).ravel() for part in function(active, place, rate, torque, push, 0.0))
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
    v, a, impulse, pressed = (np.asarray(part).ravel() for part in impacts()(active, landing, place, rate))
    D, _, J, _, _ = terms(place, rate)
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
    states = zip(*random_states(WALKER, 20), strict=True)
    stands = [impacts()(np.ones(4), np.eye(4)[0], place, rate)[1] for place, rate in states]
    assert sum(float(ca.sum1(feet)) < 3.5 for feet in stands) > 5


def test_a_heavier_base_is_that_of_a_heavier_robot() -> None:
    """Mass and inertia of the base link times 1.3, in the model itself."""
    n, base = WALKER.size, WALKER.links[0]
    heavier = replace(base, mass=1.3 * base.mass, inertia=frozen(1.3 * np.asarray(base.inertia)))
    changed = Contacts(replace(WALKER, links=(heavier, *WALKER.links[1:])), WALKER.foot_names)
    symbols = [ca.SX.sym(name, size) for name, size in zip("aqvuf", (4, n, n, n - 6, 3), strict=True)]
    found = unilateral_motion(CONTACTS, *[*symbols, ca.SX(0.3)])
    expected = unilateral_motion(changed, *[*symbols, ca.SX(0.0)])
    both = ca.Function("both", symbols, [found.acceleration, expected.acceleration, found.forces, expected.forces])
    (place,), (rate,) = random_states(WALKER, 1)
    accelerations = both([1.0, 0.0, 1.0, 1.0], place, rate, np.linspace(-5.0, 5.0, n - 6), [10.0, 20.0, 30.0])
    for one, other in (accelerations[:2], accelerations[2:]):
        np.testing.assert_allclose(np.asarray(one), np.asarray(other), atol=1e-8 * np.abs(np.asarray(other)).max())
