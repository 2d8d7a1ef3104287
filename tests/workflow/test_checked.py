"""A mesh is made finer until a gait passes its check, or what fails is said."""

from __future__ import annotations

from dataclasses import replace

import pytest

from amble.gait import Gait
from amble.synthesis import GaitProblem, synthesize
from amble.workflow.checked import until_checked


@pytest.fixture(scope="module")
def problem(small_problem: GaitProblem) -> GaitProblem:
    """ASTRo's amble on four intervals a domain: too coarse for the check, a hip is 2e-3 beyond its range."""
    limits = replace(small_problem.limits, acceleration=1e3, speeds={})
    return replace(small_problem, intervals=4, node_margins=True, limits=limits)


@pytest.fixture(scope="module")
def coarse(problem: GaitProblem) -> Gait:
    return synthesize(problem)


def test_a_mesh_is_made_finer_until_the_check_passes(
    problem: GaitProblem, coarse: Gait, caplog: pytest.LogCaptureFixture
) -> None:
    found = until_checked(problem, coarse)
    assert found.passed
    assert found.factor == 2
    assert found.gait.domains[0].times.size == 2 * 8 + 1
    assert "to 8 intervals a domain, until the gait passed its check" in caplog.text


def test_what_no_mesh_mends_is_said(problem: GaitProblem, coarse: Gait, caplog: pytest.LogCaptureFixture) -> None:
    """Feet that swing higher than legs are long."""
    higher = replace(coarse, limits=replace(coarse.limits, clearance=1.0))
    found = until_checked(replace(problem, limits=higher.limits), higher, most_iterations=3)
    assert not found.passed
    assert found.gait is higher
    assert "no gait was found on 2 times the intervals" in caplog.text
    assert "the gait does not pass its check" in caplog.text
