"""The named gaits: how many feet stand, when they fly, and which robots have them."""

from __future__ import annotations

from dataclasses import replace

import pytest

from amble.errors import InputError
from amble.hybrid import FLAT, POINT, GaitPattern
from amble.hybrid.gaits import GAITS, SHIPPED, NamedGait
from amble.robot import Robot
from tests.robots import hexapod, robot

FEET = {
    "amble": "2222",
    "trot": "22",
    "walking trot": "2424",
    "running trot": "2020",
    "pace": "22",
    "bound": "22",
    "pronk": "40",
    "walk": "32323232",
    "crawl": "43434343",
    "run": "1010",
    "tripod": "33",
}


def _biped() -> Robot:
    """ASTRo on its front legs alone, called l and r; the hind legs hang."""
    astro = robot("astro")
    feet = tuple(replace(foot, name=foot.name[1]) for foot in astro.feet if foot.name in ("fl", "fr"))
    return replace(astro, name="biped", feet=feet, twins=(("l", "r"),))


def _robot(gait: str) -> Robot:
    return {"run": _biped, "tripod": _six}.get(gait, lambda: robot("astro"))()


def _six() -> Robot:
    return replace(hexapod(), twins=(("fl", "fr"), ("ml", "mr"), ("rl", "rr")))


@pytest.mark.parametrize("gait", FEET)
def test_feet_on_the_ground(gait: str) -> None:
    pattern = GAITS[gait](_robot(gait), FLAT, POINT)
    assert "".join(str(len(stance.feet)) for stance in pattern.stances) == FEET[gait]
    assert pattern.name == gait
    landed = [foot for switch in pattern.all_switches for foot in switch.landing]
    lifted = [foot for switch in pattern.all_switches for foot in switch.lifting]
    assert sorted(landed) == sorted(lifted) == sorted(pattern.robot.foot_names)  # every foot once a cycle


def test_feet_land_one_by_one_but_those_of_a_bound_and_more_than_two() -> None:
    rules = {gait: GAITS[gait](_robot(gait), FLAT, POINT).landing_rule for gait in FEET}
    assert rules == dict.fromkeys(FEET, "one by one") | dict.fromkeys(("bound", "pronk", "tripod"), "simultaneous")


def test_every_shipped_gait_is_here() -> None:
    assert {gait.name for gait in SHIPPED} == set(FEET)


def test_a_biped_walks_on_one_foot_and_pronks_on_two() -> None:
    for gait, stances in (("walk", [("l",), ("r",)]), ("pronk", [("l", "r"), ()])):
        assert [stance.feet for stance in GAITS[gait](_biped(), FLAT, POINT).stances] == stances


def test_feet_of_other_names_are_refused_with_those_that_are_known() -> None:
    with pytest.raises(InputError, match=r"gait 'walk' is for feet called fl, fr, rl, rr or l, r; robot 'hexapod' has"):
        GAITS["walk"](_six(), FLAT, POINT)


def test_a_gait_of_ones_own_is_a_table() -> None:
    own = NamedGait(name="hop", tables=((("l",), ()),), mirrored=False)
    pattern: GaitPattern = own(replace(_biped(), feet=_biped().feet[:1], twins=()))
    assert [stance.feet for stance in pattern.stances] == [("l",), ()]
