"""Refinement keeps the motion and divides its error by the fourth power of the factor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.synthesis import GaitProblem, refine
from amble.verification.check import check


@pytest.fixture(scope="module")
def problem(small_problem: GaitProblem, walking_gait: Gait) -> GaitProblem:
    """The problem of the gait at hand."""
    return replace(small_problem, limits=walking_gait.limits)


@pytest.mark.parametrize("factor", [2, 3])
def test_the_motion_stays_and_its_error_falls(problem: GaitProblem, walking_gait: Gait, factor: int) -> None:
    finer = refine(problem, walking_gait, factor)
    assert finer.solver.violation < 1e-9
    assert finer.solver.iterations == walking_gait.solver.iterations
    # the mean of |u|^2 by Simpson's rule on the coarse mesh is accurate to a few parts in a million
    assert finer.solver.objective == pytest.approx(walking_gait.solver.objective, rel=3e-5)
    for ours, theirs in zip(finer.domains, walking_gait.domains, strict=True):
        assert ours.times.size == factor * (theirs.times.size - 1) + 1
        assert ours.duration == pytest.approx(theirs.duration, abs=1e-5)
        # what the coarse mesh was wrong by: 1e-5 rad and 2e-4 rad/s
        np.testing.assert_allclose(ours.coefficients, theirs.coefficients, atol=1e-4)
        np.testing.assert_allclose(ours.positions[::factor], theirs.positions, atol=1e-4)
        np.testing.assert_allclose(ours.velocities[::factor], theirs.velocities, atol=2e-3)
    assert finer.multipliers is walking_gait.multipliers  # so that a neighbour on the first mesh still starts warm
    before, after = (abs(check(gait).worst["motion"].row.value) for gait in (walking_gait, finer))
    assert 0.6 * factor**4 < before / after < 1.5 * factor**4  # the next term of the error is not small yet


def test_one_is_not_finer(problem: GaitProblem, walking_gait: Gait) -> None:
    with pytest.raises(InputError, match="at least 2"):
        refine(problem, walking_gait, 1)
