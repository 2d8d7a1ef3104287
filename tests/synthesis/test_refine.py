"""Refinement keeps the motion and divides its error by the fourth power of the factor."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import splu

from amble.control import joint_outputs
from amble.control.laws import law_for
from amble.errors import InputError
from amble.gait import Gait
from amble.synthesis import GaitProblem, refine
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.refine import Split
from amble.verification.check import check


@pytest.fixture(scope="module")
def problem(small_problem: GaitProblem, walking_gait: Gait) -> GaitProblem:
    """The problem of the gait at hand."""
    return replace(small_problem, limits=walking_gait.limits)


@pytest.fixture
def unmirrored(small_problem: GaitProblem, monkeypatch: pytest.MonkeyPatch) -> GaitProblem:
    """All four domains of the amble, under a law that is a row a domain as well; interpreted, for it is called once."""
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    pattern = replace(small_problem.pattern, mirrored=False)
    limits = replace(small_problem.limits, durations={stance.name: (0.1, 0.3) for stance in pattern.solved})
    law = law_for(pattern, "drop")
    outputs = joint_outputs(pattern)
    return replace(small_problem, pattern=pattern, outputs=outputs, law=law, limits=limits, intervals=3)


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
    before, after = (abs(check(gait).worst["motion"].value) for gait in (walking_gait, finer))
    assert 0.6 * factor**4 < before / after < 1.5 * factor**4  # the next term of the error is not small yet


def test_every_domain_is_an_initial_value_problem(small_program: GaitProgram, unmirrored: GaitProblem) -> None:
    """Newton's inner system is square and regular, whatever rows are called, and the parts share no row or variable."""
    for program in (small_program, build_program(unmirrored)):
        split = Split.of(program)
        assert split.inner_rows.size == split.inner.size
        natural = initial_guess(program.problem, program.layout)
        point = natural / program.layout.scale + np.random.default_rng(4).uniform(-0.02, 0.02, natural.size)
        _, slopes = program.program.linearised(point, program.parameters)
        inner = slopes[split.inner_rows][:, split.inner].tocsc()
        pivots = np.abs(splu(inner).U.diagonal())
        assert pivots.min() > 1e-9 * pivots.max()
        equations = np.flatnonzero(program.program.equalities)
        assert sorted([*split.inner_rows, *split.outer_rows]) == list(equations)
        assert not set(split.inner) & set(split.outer)


def test_one_is_not_finer(problem: GaitProblem, walking_gait: Gait) -> None:
    with pytest.raises(InputError, match="1 new intervals for each old one were asked for"):
        refine(problem, walking_gait, 1)
