"""Residuals have no unit: the same gait of another size leaves the same ones."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from amble.gait.files import load_gait
from amble.hybrid import Contacts
from amble.hybrid.contact import PointContact
from amble.robot import catalogue
from amble.verification.check import check
from amble.verification.residuals import of_contacts, size_of, sizes
from tests.similar import similar, similar_robot

BIPED = Path(__file__).parents[1] / "data" / "biped-of-small-basin.json"
LIMITS = ("duration", "normal force", "penetration", "clearance", "position", "speed", "torque limit", "touchdown")


@pytest.mark.parametrize(("mass", "length"), [(0.1, 0.05), pytest.param(1000.0, 3.0, marks=pytest.mark.slow)])
def test_a_similar_gait_has_the_same_residuals(mass: float, length: float) -> None:
    gait = load_gait(BIPED)
    here, there = check(gait, grid=2), check(similar(gait, mass / gait.robot.mass, length), grid=2)
    assert [finding.name for finding in here.rows] == [finding.name for finding in there.rows]
    assert [finding.passed for finding in here.rows] == [finding.passed for finding in there.rows]
    for one, other in zip(here.rows, there.rows, strict=True):
        if one.kind not in (*LIMITS, "acceleration limit", "friction") and "before touchdown" not in one.name:
            # 1e-9: integrations of absolute tolerance 1e-11, in other units; and sums of other rounding
            assert other.value == pytest.approx(one.value, abs=1e-9, rel=1e-6), one.name


@pytest.mark.parametrize("seed", range(3))
def test_smallest_sizes_scale_by_their_dimension(seed: int) -> None:
    draw = np.random.default_rng(seed)
    robot = catalogue.astro()
    mass, length = np.exp(draw.normal(size=2))
    here, there = sizes(robot), sizes(similar_robot(robot, float(mass), float(length)))
    assert there.length == pytest.approx(length * here.length)
    assert there.velocity == pytest.approx(np.sqrt(length) * here.velocity)
    assert there.force == pytest.approx(mass * here.force)
    assert there.torque == pytest.approx(mass * length * here.torque)
    assert there.impulse == pytest.approx(mass * np.sqrt(length) * here.impulse)
    np.testing.assert_allclose(there.loads[:3], mass * here.loads[:3])
    np.testing.assert_allclose(there.loads[3:], mass * length * here.loads[3:])
    np.testing.assert_allclose(there.rates[3:], here.rates[3:] / np.sqrt(length))
    np.testing.assert_allclose(there.accelerations[3:], here.accelerations[3:] / length)


def test_a_size_is_the_largest_share_in_every_column_s_unit() -> None:
    values = np.array([[0.0, 3.0], [-4.0, 1.0]])
    np.testing.assert_allclose(size_of(values, np.array([2.0, 10.0])), [2.0 * 3.0, 10.0 * 3.0])
    np.testing.assert_allclose(size_of(values, 0.5), [4.5])
    np.testing.assert_allclose(size_of(np.zeros((0, 2)), 0.5), [0.5])


def test_moments_of_a_contact_have_sizes_of_their_own() -> None:
    class Pivot(PointContact):
        @property
        def moments(self) -> tuple[str, ...]:
            return ("turn",)

    robot = catalogue.astro()
    contacts = Contacts(robot, robot.foot_names[:2], Pivot())
    np.testing.assert_array_equal(of_contacts(contacts, 2.0, 3.0), 2 * [2.0, 2.0, 2.0, 3.0])
    assert len(of_contacts(contacts, 2.0, 3.0)) == contacts.size
