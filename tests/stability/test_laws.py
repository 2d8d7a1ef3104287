"""Whatever the allocation law, orbit and multipliers are the same (docs/theory/allocation.md, section 1)."""

from __future__ import annotations

import numpy as np

from amble.control import MinimumPower
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.stability.monodromy import monodromy
from amble.stability.poincare import poincare_map


def test_the_law_with_the_most_different_torques_keeps_map_and_radius(stabilised_gait: Gait) -> None:
    start = start_state(stabilised_gait)
    loops = [closed_loop(stabilised_gait, law, half=True) for law in (None, MinimumPower("datasheet"))]
    beside = start + np.random.default_rng(0).normal(0.0, 1e-4, start.size)
    first, second = (poincare_map(loop, beside) for loop in loops)
    # the integrator's tolerance of 1e-10 and more, times the growth of one arc
    assert np.max(np.abs(first - second)) <= 1e-8
    radii = [np.max(np.abs(np.linalg.eigvals(monodromy(loop, start).matrix))) for loop in loops]
    assert abs(radii[0] - radii[1]) <= 1e-6
