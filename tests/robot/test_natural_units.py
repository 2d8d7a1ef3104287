"""Natural units, and robots that have none."""

from __future__ import annotations

from dataclasses import replace

import pytest

from amble.errors import InputError
from amble.robot.natural_units import natural_units, velocity_unit
from amble.verification.residuals import sizes
from tests.robots import robot


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
