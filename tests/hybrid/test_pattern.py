"""Stance tables: the switches that follow from them, and the tables that are refused."""

from __future__ import annotations

import pytest

from amble.errors import InputError, UnknownNameError
from amble.hybrid import FLAT, POINT, GaitPattern, gait_pattern
from amble.hybrid.gaits import GAITS, amble, trot
from amble.robot import Robot
from tests.robots import ROBOTS, robot


@pytest.fixture
def astro() -> Robot:
    return robot("astro")


def test_the_amble_of_the_paper(astro: Robot) -> None:
    pattern = amble(astro)
    assert [set(stance.feet) for stance in pattern.stances] == [
        {"fr", "rl"},
        {"fr", "rr"},
        {"fl", "rr"},
        {"fl", "rl"},
    ]
    assert [(switch.landing, switch.lifting) for switch in pattern.all_switches] == [
        (("rr",), ("rl",)),
        (("fl",), ("fr",)),
        (("rl",), ("rr",)),
        (("fr",), ("fl",)),
    ]
    assert [stance.name for stance in pattern.solved] == ["D1", "D2"]
    assert [switch.name for switch in pattern.switches] == ["D1->D2", "D2->D3"]


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("gait", ["amble", "trot"])
def test_every_gait_keeps_feet_in_the_robots_order(name: str, gait: str) -> None:
    pattern = GAITS[gait](robot(name), FLAT, POINT)
    order = pattern.robot.foot_names
    for stance in pattern.stances:
        assert list(stance.feet) == sorted(stance.feet, key=order.index)
        assert 0 < len(stance.feet) < len(order)
    for switch in pattern.all_switches:
        assert set(switch.target.feet) == set(switch.source.feet) - set(switch.lifting) | set(switch.landing)


def test_over_a_cycle_every_foot_that_lands_lifts(astro: Robot) -> None:
    for pattern in (amble(astro), trot(astro)):
        landed = [foot for switch in pattern.all_switches for foot in switch.landing]
        lifted = [foot for switch in pattern.all_switches for foot in switch.lifting]
        assert sorted(landed) == sorted(lifted)


def test_a_gait_without_mirror_solves_every_stance(astro: Robot) -> None:
    pattern = gait_pattern(astro, [("fl", "fr", "rl"), ("fl", "fr", "rl", "rr")])
    assert pattern.solved == pattern.stances
    assert pattern.switches == pattern.all_switches
    assert pattern.switches[1].lifting == ("rr",)
    assert pattern.switches[1].landing == ()


@pytest.mark.parametrize(
    ("table", "mirrored", "error", "says"),
    [
        ([("fl", "hind")], False, UnknownNameError, "unknown foot 'hind'; known: fl, rl, fr, rr"),
        ([("fl", "fl"), ("fr",)], False, InputError, "row 1 of the stance table repeats a foot"),
        ([("fl", "rr")], False, InputError, "at least two stances"),
        ([], False, InputError, "at least two stances"),
        ([("fl", "rr"), ("rr", "fl")], False, InputError, "have the same feet"),
        ([("fl",), ("fr",), ("rl",)], True, InputError, "even number of stances"),
        ([("fl", "rr"), ("fl", "rl")], True, InputError, "is not the mirror image of 'D1'"),
    ],
)
def test_bad_tables(
    astro: Robot, table: list[tuple[str, ...]], mirrored: bool, error: type[InputError], says: str
) -> None:
    with pytest.raises(error, match=says):
        gait_pattern(astro, table, mirrored)


def test_an_unknown_stance_says_what_is_known(astro: Robot) -> None:
    pattern: GaitPattern = amble(astro)
    assert pattern.stance("D3").feet == ("fl", "rr")
    with pytest.raises(UnknownNameError, match="unknown stance 'D5'; known: D1, D2, D3, D4"):
        pattern.stance("D5")
