"""How the fleet's gaits walk: extremes against other ways to them."""

from __future__ import annotations

from dataclasses import replace
from math import radians
from pathlib import Path

import numpy as np
import pytest

from amble.gait.files import load_gait
from amble.robot import kinematics
from benchmarks.fleet_style import BASE, CLEARANCE, KNEES, WalkingStyle, _foot, _least_bend, _places, walking_style
from tests.robots import EVERY_BASE, random_states, robot

TROT = Path(__file__).parents[1] / "data" / "trot.json"


@pytest.mark.parametrize("name", EVERY_BASE)
def test_feet_are_where_kinematics_has_them(name: str) -> None:
    walker = robot(name)
    for q in random_states(walker, 3)[0]:
        places = _places(walker, q)
        for foot in walker.foot_names:
            want = np.asarray(kinematics.foot_position(walker, foot, q)).ravel()
            np.testing.assert_allclose(_foot(walker, foot, places), want, atol=1e-12 * (1.0 + np.abs(want).max()))


def test_a_knee_is_bent_by_half_a_turn_less_its_angle() -> None:
    """ASTRo's shanks lie on the thighs at zero, and turn about the axis of the hip's pitch."""
    walker = robot("astro")
    q = np.zeros(walker.size)
    assert abs(_least_bend(walker, _places(walker, q)) - np.pi) < 1e-6
    for number, leg in enumerate(walker.legs.values()):
        q[walker.coordinate_index(leg[-1])] = (-1) ** number * (2.0 + 0.1 * number)
    assert abs(_least_bend(walker, _places(walker, q)) - (np.pi - 2.3)) < 1e-12


def test_extremes_of_a_stored_trot() -> None:
    gait = load_gait(TROT)
    found, (domain,) = walking_style(gait), gait.domains
    named = gait.robot.base.coordinates
    base = domain.positions[:, [named.index("roll"), named.index("pitch")]]
    assert found.base == np.abs(base).max()
    landing = gait.pattern.all_switches[0].landing
    jacobians = [np.asarray(kinematics.foot_jacobian(gait.robot, foot, domain.positions[-1])) for foot in landing]
    speeds = [np.linalg.norm(jacobian @ domain.velocities[-1]) for jacobian in jacobians]
    unit = np.sqrt(gait.robot.gravity * gait.robot.leg_length)
    assert abs(found.touchdown - max(speeds) / unit) < 1e-8  # differences of 1e-6
    middle = domain.positions[len(domain.times) // 2]
    swings = [foot for foot in gait.robot.foot_names if foot not in gait.pattern.solved[0].feet]
    heights = [np.asarray(kinematics.foot_position(gait.robot, foot, middle)).ravel()[2] for foot in swings]
    assert found.clearance * gait.robot.leg_length >= min(heights)


def test_what_is_missed_is_named() -> None:
    kept = WalkingStyle(base=BASE, knees=KNEES, touchdown=0.49, clearance=CLEARANCE)
    assert kept.missed == ()
    assert replace(kept, knees=radians(14.0), touchdown=0.5).missed == ("knees", "touchdown")
    assert replace(kept, base=0.11, clearance=0.07).missed == ("base", "clearance")
