"""Two bodies that land in turn: the map of one order, continued to where the other comes first, is known exactly."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.gait.landing_domains import continued
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import simulate
from amble.stability.monodromy import prepare_variational
from amble.stability.poincare import difference_check
from amble.types import Matrix, Vector

FALL = np.array([-1.0, -1.5])
"""Both bodies in the air."""

AFTER = {0: np.array([0.3, -2.0]), 1: np.array([-0.8, 0.2])}
"""One of them down: the one that is still in the air falls at another speed, and what has landed creeps."""

THROWN = np.array([0.4, 0.6])
KEPT = np.array([[0.5, 0.3], [-0.2, 0.4]])


def ordered(first: int) -> HybridSystem:
    """Body ``first`` lands before the other; both are thrown up again when the other has landed."""
    x, second = ca.SX.sym("x", 2), 1 - first
    air, down = Domain.from_expressions("air", x, ca.DM(FALL)), Domain.from_expressions("down", x, ca.DM(AFTER[first]))
    lands = Transition.from_expressions("air", "down", x, x[first], x)
    last = Transition.from_expressions("down", "air", x, x[second], ca.DM(THROWN) + ca.DM(KEPT) @ x, at_entry=True)
    back, both_ways = continued(down, last)
    return HybridSystem([air, down, back], [lands, *both_ways])


def slope(first: int) -> Matrix:
    """The map's matrix: fall until the first lands, creep until the second does, be thrown up."""
    second = 1 - first
    until = np.eye(2) - np.outer(FALL, np.eye(2)[first]) / FALL[first]
    onward = np.eye(2) - np.outer(AFTER[first], np.eye(2)[second]) / AFTER[first][second]
    return np.asarray(KEPT @ onward @ until)


def image(first: int, start: Vector) -> Vector:
    return THROWN + slope(first) @ start


@pytest.mark.parametrize("first", [0, 1])
@pytest.mark.parametrize("seed", range(6))
def test_the_continued_map_is_linear_on_both_sides(first: int, seed: int) -> None:
    start = np.random.default_rng(seed).uniform(0.2, 0.9, 2)
    trace = simulate(ordered(first), start, 1, 1e-12)
    assert trace.completed, trace.ended
    np.testing.assert_allclose(trace.events[-1].after, image(first, start), atol=1e-10)
    found = prepare_variational(ordered(first))(start)
    np.testing.assert_allclose(found.matrix, slope(first), atol=1e-8)
    went_back = any("back" in event.transition for event in trace.events)
    early = start[1 - first] / -FALL[1 - first] < start[first] / -FALL[first]
    assert went_back == early


@pytest.mark.parametrize("first", [0, 1])
def test_differences_across_the_edge_agree(first: int) -> None:
    """Where both land at once half of the changed starts go back; one by one without going back it is a kink."""
    start = -0.4 * FALL
    found = difference_check(ordered(first), start)
    np.testing.assert_allclose(found.matrix, slope(first), atol=1e-7)
    assert np.abs(slope(0) - slope(1)).max() > 0.1
    np.testing.assert_allclose(image(0, start), image(1, start), atol=1e-15)  # the true map is continuous there
