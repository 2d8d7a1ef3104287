"""The map of many starts in one native call: that of ``walk`` to the last bit, and what it leaves to it."""

from __future__ import annotations

import numpy as np
import pytest

from amble.hybrid import HybridSystem
from amble.simulation.library import load
from amble.simulation.native_map import NativeMap, native_map
from amble.simulation.prepared import prepare, prepare_domain
from amble.simulation.walk import walk
from amble.types import NodeValues
from tests.hybrids import bouncing_ball, clockwork, two_phases

TOLERANCE, LIMIT, STEP = 1e-10, 10.0, 0.01

pytestmark = pytest.mark.skipif(load("dormand_prince") is None, reason="no C compiler on this machine")


def _map(system: HybridSystem) -> NativeMap:
    names = [domain.name for domain in system.domains]
    found = native_map(system, {name: (prepare_domain(system, name), prepare(system, name)) for name in names})
    assert found is not None
    return found


def _walked(system: HybridSystem, starts: NodeValues, cycles: int) -> NodeValues:
    motions = [walk(system, start, cycles, TOLERANCE, 2, LIMIT, max_step=STEP) for start in starts]
    assert all(motion.cycles == cycles for motion in motions)
    return np.array([motion.events[-1].after for motion in motions])


@pytest.mark.parametrize("cycles", [1, 3])
def test_it_is_the_walk_to_the_last_bit(cycles: int) -> None:
    """Two domains with parameters, guards and resets that depend on the clock."""
    system = two_phases()
    starts = np.array([0.2, 0.5, 0.1]) + np.random.default_rng(1).normal(scale=0.05, size=(5, 3))
    images, returned = _map(system)(starts, TOLERANCE, LIMIT, STEP, cycles)
    assert returned.all()
    assert np.array_equal(images, _walked(system, starts, cycles))


def test_starts_that_do_not_come_back_are_told() -> None:
    """A ball that is too slow is dead at its entry, one that is no number has no motion; others are as ever."""
    system = bouncing_ball(floor=1.0)
    starts = np.array([[0.0, 3.0], [0.0, 0.5], [0.0, np.nan], [0.0, 2.0]])
    images, returned = _map(system)(starts, TOLERANCE, LIMIT, STEP, 1)
    assert returned.tolist() == [True, False, False, True]
    assert np.array_equal(images[[0, 3]], _walked(system, starts[[0, 3]], 1))


def test_a_motion_without_an_event_does_not_come_back() -> None:
    """Within the time limit: the line is crossed at 1 s; and a guard that is no number ends the motion."""
    assert not _map(clockwork(("line", +1, 0.0)))(np.zeros((1, 1)), TOLERANCE, 0.5, STEP, 1)[1].any()
    assert not _map(clockwork(("nan", -1, 0.0)))(np.zeros((1, 1)), TOLERANCE, LIMIT, STEP, 1)[1].any()


def test_stays_that_may_accumulate_are_left_to_the_walk() -> None:
    """A ball after a hundred bounces: each takes 0.8 of the time of the one before."""
    _, returned = _map(bouncing_ball())(np.array([[0.0, 1.0]]), TOLERANCE, LIMIT, STEP, 100)
    assert not returned.any()
