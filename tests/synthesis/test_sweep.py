"""Many gaits of one structure, one after the other."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.synthesis import GaitProblem
from amble.synthesis.sweep import sweep
from tests.grounds import on_friction


def test_neighbours_start_from_each_other(small_problem: GaitProblem) -> None:
    """The nearest neighbour is the problem itself."""
    first, second = sweep([small_problem, small_problem])
    assert not first.warm
    assert second.warm
    assert second.iterations < first.iterations
    assert first.gait is not None
    assert second.gait is not None
    assert second.gait.solver.violation < 1e-6
    assert second.gait.solver.objective == pytest.approx(first.gait.solver.objective, rel=1e-4)
    assert second.seconds > 0.0


@pytest.mark.slow
def test_friction_changes_without_building_another_program(small_problem: GaitProblem) -> None:
    """Each gait keeps its own cone, and less friction costs more torque: a smaller set has no smaller minimum."""
    frictions, coarse = (0.6, 0.2), replace(small_problem, intervals=3)
    problems = [on_friction(coarse, mu) for mu in frictions]
    costs, used = [], []
    for outcome in sweep(problems):
        assert outcome.gait is not None, outcome.status
        costs.append(outcome.gait.solver.objective)
        forces = np.concatenate([domain.forces.reshape(-1, 3) for domain in outcome.gait.domains])
        used.append(np.max(np.hypot(forces[:, 0], forces[:, 1]) / forces[:, 2]))
    assert all(share < mu for share, mu in zip(used, frictions, strict=True))
    assert used[0] > frictions[1]  # so that the smaller coefficient binds
    assert costs[1] > costs[0] * 1.0001


def test_a_failure_is_reported_and_the_sweep_goes_on(small_problem: GaitProblem) -> None:
    impossible = replace(small_problem, speed=20.0)
    first, second = sweep([impossible, small_problem], most_iterations=50)
    assert first.gait is None
    assert "worst" in first.status
    assert second.gait is not None
    assert not second.warm


@pytest.mark.slow
def test_one_structure(small_problem: GaitProblem) -> None:
    with pytest.raises(InputError, match="one structure"):
        list(sweep([small_problem, replace(small_problem, intervals=6)]))
