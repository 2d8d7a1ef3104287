"""Gaits that turn or go sideways are stabilised and certified as those that go straight; with any rule of landing."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from amble.analysis import ContactBounds, contact_report
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.hybrid import ONE_BY_ONE
from amble.hybrid.gaits import trot
from amble.simulation import simulate
from amble.stability import certify
from amble.stability.gait_certificate import distances
from amble.stability.stabilize import stabilize
from amble.synthesis import gait_problem, synthesize
from amble.verification.check import check
from tests.robots import robot

GAIT = Path(__file__).parents[1] / "data" / "turning-trot.json"

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def gait() -> Gait:
    """Stabilised: forward 0.2 m/s, to the left 0.05 m/s, 0.5 rad/s."""
    return load_gait(GAIT)


def walked(gait: Gait, cycles: int) -> None:
    trace = simulate(gait, cycles=cycles, perturbation=1e-3, seed=2)
    assert trace.completed, trace.ended
    report = contact_report(trace, gait.pattern, ContactBounds.of_gait(gait))
    assert report.sound_from is not None
    assert report.max_drift < 1e-3


def test_a_turning_gait_is_certified_and_walks_five_hundred_cycles(gait: Gait) -> None:
    certificate = certify(gait)
    assert certificate.radius < 0.4
    translation = next(symmetry for symmetry in certificate.spectrum.neutral if symmetry.name == "x")
    assert translation.multiplier == pytest.approx(np.cos(gait.turn), abs=1e-9)
    walked(gait, 500)
    trace = simulate(gait, cycles=12, perturbation=1e-4, seed=3)
    apart = distances(gait, trace, certificate)
    assert apart[-1] < 1e-2 * apart[0]  # the radius is 0.35; the heading would grow with the cycles


def test_weights_are_found_and_the_check_comes_back_to_them(gait: Gait) -> None:
    bare = replace(gait, feedback=None)
    stable = stabilize(bare)
    rows = [row for row in check(stable).rows if "feedback returns" in row.name]  # on 10 intervals feet miss by 1e-5 l
    assert rows
    assert all(row.passed for row in rows)
    assert certify(stable).radius < 0.95


def test_under_impedance_it_is_certified_whatever_its_heading(gait: Gait) -> None:
    certificate = certify(stabilize(replace(gait, control=Impedance())))
    assert certificate.radius < 1.0
    assert [symmetry.name for symmetry in certificate.spectrum.neutral] == ["x", "y", "yaw"]


def test_a_gait_to_the_side_is_certified_and_walks() -> None:
    walking = synthesize(gait_problem(robot("astro"), "trot", speed=0.2, lateral_speed=0.1, intervals=10))
    assert not walking.pattern.mirrored
    stable = stabilize(walking)
    assert certify(stable).radius < 0.95
    walked(stable, 100)


def test_feet_of_a_turning_gait_may_land_one_by_one() -> None:
    pattern = replace(trot(robot("astro")), mirrored=False, landing_rule=ONE_BY_ONE)
    walking = synthesize(gait_problem(pattern.robot, pattern, speed=0.2, yaw_rate=0.4, intervals=10))
    stable = stabilize(walking)
    certificate = certify(stable)
    assert certificate.landing is not None
    assert certificate.landing.bound.rate < 0.9
    walked(stable, 100)
