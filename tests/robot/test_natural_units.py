"""Natural units, and robots that have none."""

from __future__ import annotations

from dataclasses import replace

import pytest

from amble.errors import InputError
from amble.gait.limits import highest_landing
from amble.robot.natural_units import natural_units, velocity_unit
from amble.verification.residuals import sizes
from tests.robots import robot


def test_gravity_counts_by_its_size() -> None:
    astro = robot("astro")
    upwards = replace(astro, gravity=-astro.gravity)
    assert velocity_unit(upwards) == velocity_unit(astro)
    assert highest_landing(upwards) == highest_landing(astro) < 0.0


@pytest.mark.parametrize("what", ["mass", "gravity", "leg length"])
def test_a_robot_without_natural_units_is_refused_by_name(what: str) -> None:
    astro = robot("astro")
    if what == "mass":
        changed = replace(astro, links=tuple(replace(link, mass=0.0) for link in astro.links))
    elif what == "gravity":
        changed = replace(astro, gravity=0.0)
    else:
        changed = replace(astro, feet=(), twins=())
    for measure in (velocity_unit, sizes, lambda model: natural_units(model, model.leg_length)):
        with pytest.raises(InputError, match=f"the {what} .* is 0"):
            measure(changed)
