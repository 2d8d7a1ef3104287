"""References of a closed loop's own orbit over another phase: the orbit stays, its stability need not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.gait import Gait
from amble.simulation import simulate
from amble.stability.closed_loop_orbit import (
    FIT_SAMPLES,
    FIT_TOLERANCE,
    bare_fixed_point,
    closed_loop_fixed_point,
    feedback_on,
)
from tests.phases import on_phase


def test_an_orbit_is_one_over_the_configuration_too(walking_gait: Gait) -> None:
    """The lateral sway of the base drives D1; in D2, where the outputs hold all that grows, time does."""
    system, found = closed_loop_fixed_point(walking_gait)
    orbit = simulate(system, found.state, 1, FIT_TOLERANCE, samples=FIT_SAMPLES)
    gait = on_phase(walking_gait, {"D1": {"y": -1.0}})
    gait = replace(gait, feedback=feedback_on(gait, orbit))
    swaying, again = closed_loop_fixed_point(gait)
    assert [len(domain.breakpoints) for domain, _ in swaying.cycle()] == [0, 1]
    assert swaying.domains[0].parameters.size == system.domains[0].parameters.size + 2
    assert again.residual < 1e-10
    # references of order 14 meet the motion over the sway to about 1e-9
    np.testing.assert_allclose(again.state[2:], found.state[2:], atol=1e-8)
    np.testing.assert_allclose(again.monodromy.durations, found.monodromy.durations, atol=1e-8)
    # the field of D1 does not depend on the clock
    domain = swaying.domains[0]
    early, late = (np.asarray(domain.field(t, again.state, domain.parameters)) for t in (0.0, 0.3))
    np.testing.assert_array_equal(early, late)


def test_the_fixed_point_of_the_latest_gait_is_kept(stabilised_gait: Gait) -> None:
    """Of that object alone, and under the outputs of the gait problem."""
    system, found = bare_fixed_point(stabilised_gait)
    again = bare_fixed_point(stabilised_gait)
    assert again == (system, found)
    assert again[1] is found
    other = replace(stabilised_gait)
    moved = bare_fixed_point(other)[1]
    assert moved is not found
    np.testing.assert_array_equal(moved.state, found.state)
    assert bare_fixed_point(stabilised_gait)[1] is not found
