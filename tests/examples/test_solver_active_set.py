"""The example of a solver: near a solved problem it finds what IPOPT finds, and says so where it does not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from examples.extending import solver_active_set

from amble.errors import UnknownNameError
from amble.gait import Gait
from amble.progress import ProgressReport
from amble.synthesis import GaitProblem, synthesize
from amble.synthesis.solve import SOLVERS
from amble.synthesis.specification import SolverSection
from amble.synthesis.synthesize import GaitNotSolvedError
from amble.workflow.specified import GaitNotCheckedError, PosedProblem, solve

NAME = "active set"


@pytest.fixture(scope="module")
def coarse(small_problem: GaitProblem) -> GaitProblem:
    return replace(small_problem, intervals=2)


@pytest.fixture(scope="module")
def neighbour(coarse: GaitProblem) -> Gait:
    return synthesize(coarse)


def test_it_finds_the_neighbour_that_ipopt_finds(coarse: GaitProblem, neighbour: Gait) -> None:
    faster, seen = replace(coarse, speed=0.205), list[ProgressReport]()
    ours = synthesize(faster, neighbour, progress=seen.append, solver=NAME)
    theirs = synthesize(faster, neighbour)
    assert (ours.solver.solver, ours.solver.status) == (NAME, "Converged")
    assert ours.solver.iterations < 15
    assert ours.solver.violation < 1e-7
    assert ours.solver.objective == pytest.approx(theirs.solver.objective, rel=1e-6)
    for one, other in zip(ours.domains, theirs.domains, strict=True):
        np.testing.assert_allclose(one.torques, other.torques, atol=1e-3)
    assert [report.done for report in seen] == list(range(ours.solver.iterations + 1))
    residuals = [report.value for report in seen]
    assert residuals[-1] < 1e-8  # Newton's last step squares the residual but for rounding
    assert residuals[-1] < 1e-3 * residuals[-2]


def test_from_afar_it_fails_and_says_so(coarse: GaitProblem) -> None:
    with pytest.raises(GaitNotSolvedError, match=r"Diverged|Maximum_Iterations_Exceeded"):
        synthesize(coarse, most_iterations=15, solver=NAME)


def test_a_specification_names_it(coarse: GaitProblem, neighbour: Gait) -> None:
    section = SolverSection(name=NAME, intervals=2)
    with pytest.raises(GaitNotCheckedError) as coarser:  # so few intervals do not pass the check; it solved, though
        solve(PosedProblem("a test", replace(coarse, speed=0.202), section), neighbour)
    assert coarser.value.last.solver.solver == NAME


def test_an_unknown_solver_names_those_there_are(coarse: GaitProblem) -> None:
    assert SOLVERS[NAME] is solver_active_set.active_set
    with pytest.raises(UnknownNameError, match="unknown solver 'snopt'; known: ipopt, ipopt mumps, active set"):
        synthesize(coarse, solver="snopt")
