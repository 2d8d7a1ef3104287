"""How far a gait's expressions are from its robot record: bounded, and no farther from another record than it is."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from flint import arb

from amble.proof.arithmetic import working_precision
from amble.proof.record_distance import distances
from amble.robot import Robot
from tests.proof import gaits

CHANGE = 1e-9
"""Of one number of a record: a million times what doubles round."""


def points() -> SimpleNamespace:
    """Of both stances two points, which need not be on the orbit: what is used of a proved orbit."""
    prepared, here = gaits.loop()
    with working_precision(128):
        beside = [value + arb(2) ** -7 * (number % 3) for number, value in enumerate(here)]
    return SimpleNamespace(points=[[(arb(0), here), (arb(0), beside)]] * len(prepared.legs))


def missed(robot: Robot) -> dict[str, float]:
    """Of the expressions of the tests' gait and the record of a robot."""
    prepared, _ = gaits.loop()
    with working_precision(128):
        found = distances(gaits.stabilised(), robot, prepared, points(), room=False)
    return {name: float(most) for name, most in found.items()}


def heavier(robot: Robot) -> Robot:
    first, *others = robot.links
    return replace(robot, links=(replace(first, mass=first.mass * (1 + CHANGE)), *others))


def wider(robot: Robot) -> Robot:
    first, *others = robot.links
    return replace(robot, links=(replace(first, inertia=first.inertia * (1 + CHANGE)), *others))


def longer(robot: Robot) -> Robot:
    return replace(robot, feet=tuple(replace(foot, offset=foot.offset * (1 + CHANGE)) for foot in robot.feet))


def drawn_to_the_ground(robot: Robot) -> Robot:
    return replace(robot, gravity=robot.gravity * (1 + CHANGE))


def test_expressions_are_as_near_to_the_record_as_doubles_are() -> None:
    """Forces to 1e-12 of the weight, places to 1e-12 of the legs; the file's own numbers are no doubles."""
    gait = gaits.stabilised()
    weight, found = gait.robot.mass * gait.robot.gravity, missed(gait.robot)
    assert set(found) == {
        *("force_N", "moment_N_m", "foot_acceleration_m_s2", "foot_m"),
        *("impulse_N_s", "angular_impulse_N_m_s", "landed_speed_m_s"),
    }
    assert 0.0 < found["force_N"] < 1e-12 * weight
    assert 0.0 < found["moment_N_m"] < 1e-12 * weight * gait.robot.leg_length
    assert 0.0 < found["foot_m"] < 1e-12 * gait.robot.leg_length
    assert all(0.0 < value < 1e-11 for value in found.values())


@pytest.mark.parametrize(
    ("change", "what"),
    [
        (heavier, ("force_N", "impulse_N_s")),
        (wider, ("moment_N_m", "angular_impulse_N_m_s")),
        (longer, ("foot_m", "landed_speed_m_s", "foot_acceleration_m_s2")),
        (drawn_to_the_ground, ("force_N",)),
    ],
)
def test_another_record_is_farther(change: Callable[[Robot], Robot], what: tuple[str, ...]) -> None:
    robot = gaits.stabilised().robot
    usual, other = missed(robot), missed(change(robot))
    for name in what:
        assert other[name] > 1e3 * usual[name], name
        assert other[name] > 1e-3 * CHANGE, name


def test_room_is_given_to_claims_alone() -> None:
    gait, (prepared, _) = gaits.stabilised(), gaits.loop()
    with working_precision(128):
        claimed, found = (distances(gait, gait.robot, prepared, points(), room=room) for room in (True, False))
    ratios = np.array([float(claimed[name] / most) for name, most in found.items()])
    assert ratios == pytest.approx(1 + 1 / 16, rel=1e-6)
