"""Natural units, and robots that have none."""

from __future__ import annotations

from dataclasses import replace

import pytest

from amble.errors import InputError
from amble.robot.natural_units import RobotUnits, natural_units, velocity_unit
from amble.verification.residuals import sizes
from tests.robots import robot
from tests.similar import similar_robot


@pytest.mark.parametrize("what", ["mass", "leg length"])
def test_a_robot_without_natural_units_is_refused_by_name(what: str) -> None:
    astro = robot("astro")
    if what == "mass":
        changed = replace(astro, links=tuple(replace(link, mass=0.0) for link in astro.links))
    else:
        changed = replace(astro, feet=(), twins=())
    for measure in (velocity_unit, sizes, lambda model: natural_units(model, model.leg_length)):
        with pytest.raises(InputError, match=f"the {what} .* is 0"):
            measure(changed)


@pytest.mark.parametrize(
    ("unit", "powers"),
    [
        ("1", (0, 0, 0)),
        ("rad", (0, 0, 0)),
        ("N m", (2, 1, -2)),
        ("N^2 m^2", (4, 2, -4)),
        ("rad/s^2", (0, 0, -2)),
        ("N m s/rad", (2, 1, -1)),
        ("1/s", (0, 0, -1)),
        ("W", (2, 1, -3)),
        ("J/kg m", (1, 0, -2)),
    ],
)
def test_a_unit_has_the_size_of_its_dimension(unit: str, powers: tuple[int, int, int]) -> None:
    units = RobotUnits(length=0.3, mass=7.0, time=0.2)
    expected = units.length ** powers[0] * units.mass ** powers[1] * units.time ** powers[2]
    assert units.size(unit) == pytest.approx(expected, rel=1e-14)


def test_units_of_a_robot_of_another_size_are_similar() -> None:
    """Every size follows the robot's, and at four times the length and half the mass every digit."""
    astro = robot("astro")
    here, there = (RobotUnits.of(one) for one in (astro, similar_robot(astro, mass=0.5, length=4.0)))
    assert (there.length, there.mass, there.time) == (4.0 * here.length, 0.5 * here.mass, 2.0 * here.time)
    for unit, factor in (("N m", 2.0), ("N s", 1.0), ("m/s^2", 1.0), ("kg m^2", 8.0), ("W^2", 1.0)):
        assert there.size(unit) == factor * here.size(unit)


@pytest.mark.parametrize("unit", ["Nm", "N^0 m", "deg", "N*m"])
def test_what_is_no_unit_is_refused(unit: str) -> None:
    units = RobotUnits(length=1.0, mass=1.0, time=1.0)
    with pytest.raises(InputError, match="no product of powers of 1, rad, m, kg, s, N, J, W"):
        units.size(unit)
