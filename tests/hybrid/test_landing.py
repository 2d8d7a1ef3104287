"""Feet that land one by one: every order of landing, and the law that makes the orders meet."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.control.landing import landing_plant, legs_in_the_air
from amble.errors import InputError, UnknownNameError
from amble.hybrid import ONE_BY_ONE, SIMULTANEOUS, GaitPattern, Stance, gait_pattern
from amble.hybrid.gaits import amble, trot
from amble.robot import catalogue
from amble.robot.parts import Foot
from amble.types import Vector
from amble.verification.stance_model import terms
from amble.verification.switch_rows import plastic

ROBOT = catalogue.astro()


def after(pattern: GaitPattern, q: Vector, v: Vector, *feet: str) -> Vector:
    """Velocities behind the impact that stops some feet, by a dense solve."""
    ordered = tuple(foot for foot in ROBOT.foot_names if foot in feet)
    return plastic(terms(pattern.contacts(Stance("landed", ordered)), q[None], v[None]))[0]


def test_a_pair_lands_in_two_orders_and_the_first_releases_the_old_feet() -> None:
    pattern = replace(trot(ROBOT), landing_rule=ONE_BY_ONE)
    assert [stance.name for stance in pattern.visited] == ["D1", "D2", "D2 rl", "D2 fr", "D1 fl", "D1 rr"]
    steps = {step.name: step for step in pattern.steps}
    assert set(steps) == {
        *("D1->D2 fr", "D1->D2 rl", "D2 fr->D2", "D2 rl->D2"),
        *("D2->D1 fl", "D2->D1 rr", "D1 fl->D1", "D1 rr->D1"),
    }
    assert (steps["D1->D2 fr"].landing, steps["D1->D2 fr"].lifting) == (("fr",), ("fl", "rr"))
    assert steps["D1->D2 fr"].target.feet == ("fr",)
    assert (steps["D2 fr->D2"].landing, steps["D2 fr->D2"].lifting) == (("rl",), ())


def test_old_feet_that_do_not_lift_stay() -> None:
    table = (("fl", "rr"), ROBOT.foot_names, ("fr", "rl"), ROBOT.foot_names)
    pattern = gait_pattern(ROBOT, table, True, landing_rule=ONE_BY_ONE)
    between = pattern.visited[4:]
    assert {stance.feet for stance in between} == {
        tuple(f for f in ROBOT.foot_names if f != g) for g in ROBOT.foot_names
    }
    assert all(step.lifting == () for step in pattern.steps if step.landing)


def test_four_feet_land_in_twenty_four_orders() -> None:
    pattern = gait_pattern(ROBOT, (ROBOT.foot_names, ()), landing_rule=ONE_BY_ONE)
    landings = [step for step in pattern.steps if step.landing]
    assert (len(pattern.visited), len(landings)) == (2 + 14, 4 * 2**3)
    ends = {"D2": 1}  # orders that lead to a stance: paths of the graph
    for step in landings:
        ends[step.target.name] = ends.get(step.target.name, 0) + ends[step.source.name]
    assert ends["D1"] == 24


@pytest.mark.parametrize("pattern", [amble(ROBOT), replace(trot(ROBOT), landing_rule=SIMULTANEOUS)])
def test_where_one_foot_lands_or_all_at_once_nothing_is_added(pattern: GaitPattern) -> None:
    assert pattern.visited == pattern.stances
    assert pattern.steps == pattern.all_switches
    assert replace(amble(ROBOT), landing_rule=ONE_BY_ONE).steps == amble(ROBOT).all_switches


def test_more_than_six_feet_do_not_land_one_by_one() -> None:
    """A table of 24 feet from a file: 2^23 stances between the landings took all memory."""
    astro = catalogue.load("astro")
    feet = tuple(replace(astro.feet[0], name=f"f{n}", offset=np.array([0.01 * n, 0.0, 0.0])) for n in range(24))
    many = replace(astro, feet=feet, twins=())
    table = [["f0"], [f"f{n}" for n in range(1, 24)]]
    with pytest.raises(InputError, match="'D1->D2' 23 feet land; by the landing rule 'one by one' at most 6 do"):
        gait_pattern(many, table, mirrored=False)
    assert len(gait_pattern(many, table, mirrored=False, landing_rule=SIMULTANEOUS).steps) == 2


def test_an_unknown_rule_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="unknown landing rule 'any'; known: one by one, simultaneous"):
        replace(trot(ROBOT), landing_rule="any")


@pytest.mark.parametrize("seed", range(5))
def test_landing_one_after_the_other_at_once_is_landing_together(seed: int) -> None:
    """P_ij P_i = P_ij, in both orders, and with feet that stay; where old feet are held first it is not so."""
    pattern, draw = trot(ROBOT), np.random.default_rng(seed)
    q = catalogue.posture("astro").coordinates(ROBOT) + draw.normal(0.0, 0.1, ROBOT.size)
    v = draw.normal(0.0, 1.0, ROBOT.size)
    together = after(pattern, q, v, "fr", "rl")
    size = np.max(np.abs(v))
    for first in ("fr", "rl"):
        one_by_one = after(pattern, q, after(pattern, q, v, first), "fr", "rl")
        np.testing.assert_allclose(one_by_one, together, atol=1e-10 * size)
        held = after(pattern, q, after(pattern, q, v, first, "fl", "rr"), "fr", "rl")
        assert np.max(np.abs(held - together)) > 1e-3 * size
    all_four = after(pattern, q, after(pattern, q, v, "fl", "rr", "fr"), *ROBOT.foot_names)
    np.testing.assert_allclose(all_four, after(pattern, q, v, *ROBOT.foot_names), atol=1e-10 * size)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize(("down", "late"), [(("fr",), ("rl",)), (("rl",), ("fr",)), (("fl", "fr"), ("rl", "rr"))])
def test_legs_in_the_air_go_on_and_all_else_has_its_torques(
    down: tuple[str, ...], late: tuple[str, ...], seed: int
) -> None:
    """Equations of motion by a second code path; joints of late legs keep their rates, the others their torques."""
    draw = np.random.default_rng(seed)
    q = catalogue.posture("astro").coordinates(ROBOT) + draw.normal(0.0, 0.1, ROBOT.size)
    v, u = draw.normal(0.0, 1.0, ROBOT.size), draw.normal(0.0, 10.0, len(ROBOT.joints))
    contacts = trot(ROBOT).contacts(Stance("landed", tuple(foot for foot in ROBOT.foot_names if foot in down)))
    rate, force, torque = (
        np.asarray(part).ravel() for part in landing_plant(contacts, late)(np.concatenate([q, v]), u)
    )
    at, a = terms(contacts, q[None], v[None]), rate[ROBOT.size :]
    standing = force.reshape(-1, 3)[[ROBOT.foot_names.index(foot) for foot in contacts.feet]].ravel()
    loads = at.mass[0] @ a + at.bias[0] - at.jacobian[0].T @ standing
    size = np.max(np.abs(loads))
    np.testing.assert_allclose(loads, np.concatenate([np.zeros(6), torque]), atol=1e-10 * size)
    np.testing.assert_allclose(at.jacobian[0] @ a, -at.contact_bias[0], atol=1e-10 * np.max(np.abs(a)))
    legs = {joint for foot in late for joint in ROBOT.legs[foot]}
    in_the_air = np.array([joint in legs for joint in ROBOT.joint_names])
    assert np.all(a[6:][in_the_air] == 0.0)
    np.testing.assert_array_equal(torque[~in_the_air], u[~in_the_air])
    assert np.max(np.abs(torque[in_the_air] - u[in_the_air])) > 1.0


def test_a_joint_that_a_foot_on_the_ground_needs_is_not_in_the_air() -> None:
    """Of feet whose legs share joints only those below the last common one hang."""
    foot = ROBOT.foot("fl")
    heel = Foot("heel", "heel", ROBOT.joints[foot.link - 1].parent, np.array([0.0, 0.0, -0.05]))
    robot = replace(ROBOT, feet=(foot, heel), twins=())
    names = robot.coordinate_names
    assert [names[k] for k in legs_in_the_air(robot, ("fl",), ())] == list(ROBOT.legs["fl"])
    assert [names[k] for k in legs_in_the_air(robot, ("fl",), ("heel",))] == ["fl_knee"]
