"""Inertias in another unit and joints that cannot move are found; real robots have neither."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.robot import Robot
from amble.robot.plausibility import asymmetry, doubts
from tests.robots import ROBOTS, robot


def with_inertias(model: Robot, factor: float) -> Robot:
    return replace(model, links=tuple(replace(link, inertia=factor * link.inertia) for link in model.links))


@pytest.mark.parametrize("name", ROBOTS)
def test_real_robots_are_not_doubted(name: str) -> None:
    assert doubts(robot(name)) == ()


@pytest.mark.parametrize("name", ROBOTS)
@pytest.mark.parametrize("factor", [1e6, 1e4, 1e-6], ids=["kg mm^2", "kg cm^2", "t m^2 in kg"])
def test_inertias_in_another_unit_are_found(name: str, factor: float) -> None:
    found = doubts(with_inertias(robot(name), factor))
    assert len(found) == len(robot(name).links)
    assert all("are its moments in kg m^2?" in doubt for doubt in found)


def test_a_joint_without_a_range_is_found() -> None:
    model = robot("astro")
    stiff = tuple(replace(joint, lower=0.0, upper=0.0) if joint.name == "fl_knee" else joint for joint in model.joints)
    assert doubts(replace(model, joints=stiff)) == ("joint 'fl_knee' cannot move: its range is 0 to 0 rad",)


def test_asymmetry_is_told_with_its_size() -> None:
    model = robot("astro")
    assert asymmetry(model) is None
    heavy = replace(model.links[1], mass=1.1 * model.links[1].mass)
    found = asymmetry(replace(model, links=(model.links[0], heavy, *model.links[2:])))
    assert found is not None
    assert "deviates by" in found
    assert np.isfinite(float(found.split("deviates by ")[1].split()[0]))
