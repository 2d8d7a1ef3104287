"""The return map over a box: points that are integrated in 60 digits by another method land in its enclosures."""

from __future__ import annotations

import numpy as np
import pytest
from examples import rimless_wheel, simplest_walker
from flint import arb

from amble.hybrid import HybridSystem
from amble.proof.arithmetic import column, working_precision
from amble.proof.return_map import ReturnMap
from amble.stability import fixed_point
from amble.types import Vector
from tests.proof.near import all_near, spread
from tests.proof.points import BITS, Rate, landed

ERROR = 1e-18
"""Of the integrations below: doubling the steps changes the landing by less."""


def walking(name: str) -> tuple[HybridSystem, Vector]:
    system, guess = rimless_wheel.rolling() if name == "rimless wheel" else simplest_walker.long_step()
    return system, fixed_point(system, guess).state


@pytest.mark.parametrize(
    ("name", "radius", "steps"),
    [("rimless wheel", 2.0**-20, 8), ("simplest walker", 2.0**-26, 8)],
    ids=["rimless-wheel", "simplest-walker"],
)
def test_a_thousand_starts_land_in_the_enclosures(name: str, radius: float, steps: int) -> None:
    """All at once: the centre in 60 digits, the others by their differences from it, to 15 digits of those."""
    system, start = walking(name)
    draws = np.random.default_rng(1)
    with working_precision(128):
        prepared = ReturnMap.of(system, 20, 1e-22)
        centre = [arb(float(value)) for value in start]
        found = prepared(centre, [arb(radius)] * system.state_size)
    (leg,), (arc,) = prepared.legs, found.arcs
    offsets = draws.integers(-(2**20), 2**20 + 1, (1001, system.state_size)) * radius / 2**20
    offsets[0] = 0.0
    rate: Rate = lambda clock, state: leg.field.part(clock, state).rate  # noqa: E731
    clock, after = landed(leg, rate, spread(centre, offsets), arc.duration.mid(), steps, 8)  # type: ignore[arg-type]
    image = all_near(after)
    with working_precision(BITS):
        for number, offset in enumerate(offsets):
            assert arc.duration.contains(clock.first + arb(clock.off[number])), number  # type: ignore[attr-defined]
            reached = (found.derivative * column([arb(float(value)) for value in offset])).entries()
            for ball, extra, whole, value in zip(found.centre, reached, found.image, image, strict=True):
                there = value.first + arb(float(value.off[number])) + arb(0, ERROR)
                assert whole.overlaps(there), number
                assert (ball + extra).overlaps(there), number
                assert float((ball + extra).rad()) < 0.05 * radius, number


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "radius", "steps"),
    [("rimless wheel", 2.0**-20, 4), ("simplest walker", 2.0**-26, 8)],
    ids=["rimless-wheel", "simplest-walker"],
)
def test_random_starts_land_in_the_enclosures(name: str, radius: float, steps: int) -> None:
    """The same one by one, every start in 60 digits."""
    system, start = walking(name)
    size, draws = system.state_size, np.random.default_rng(0)
    with working_precision(128):
        prepared = ReturnMap.of(system, 20, 1e-22)
        centre = [arb(float(value)) for value in start]
        found = prepared(centre, [arb(radius)] * size)
    (leg,), (arc,) = prepared.legs, found.arcs
    for number in range(1000):
        with working_precision(BITS):
            offset = [arb(int(k)) * radius / 2**20 for k in draws.integers(-(2**20), 2**20 + 1, size)]
            point = [c + o for c, o in zip(centre, offset, strict=True)]
        clock, after = landed(
            leg, lambda at, state: leg.field.part(at, state).rate, point, arc.duration.mid(), steps, 8
        )
        with working_precision(BITS):
            reached = (found.derivative * column(offset)).entries()
            assert arc.duration.contains(clock), number
            for ball, extra, whole, value in zip(found.centre, reached, found.image, after, strict=True):
                assert whole.contains(value), number
                assert (ball + extra).overlaps(value + arb(0, ERROR)), number
                assert float((ball + extra).rad()) < 0.05 * radius, number
