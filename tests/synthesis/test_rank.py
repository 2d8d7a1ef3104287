"""The rank check on a thinned mesh."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import NotSolvedError
from amble.synthesis import GaitProblem
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.rank import COARSE, on_coarse_mesh, require_full_rank


def test_a_fine_mesh_is_thinned_to_the_same_walk(small_problem: GaitProblem) -> None:
    fine = build_program(replace(small_problem, intervals=2 * COARSE))
    natural = initial_guess(fine.problem, fine.layout)
    coarse, variables = on_coarse_mesh(fine, natural)
    assert coarse.problem == replace(fine.problem, intervals=COARSE)
    thin = variables * coarse.layout.scale
    for here, there in zip(fine.layout.domains, coarse.layout.domains, strict=True):
        # every second node of the fine mesh is a node of the coarse one
        for kind in ("q", "v", "a", "u", "force"):
            np.testing.assert_allclose(thin[getattr(there, kind)], natural[getattr(here, kind)][::2], atol=1e-12)
        np.testing.assert_array_equal(thin[there.coefficients], natural[here.coefficients])
    assert require_full_rank(coarse, variables) > 1e-6


def test_a_coarse_mesh_stays(small_problem: GaitProblem) -> None:
    program = build_program(replace(small_problem, intervals=COARSE))
    natural = initial_guess(program.problem, program.layout)
    same, variables = on_coarse_mesh(program, natural)
    assert same is program
    np.testing.assert_allclose(variables * program.layout.scale, natural, rtol=1e-15)


@pytest.mark.parametrize("speed", [0.05, 0.2, 1.0, 20.0])
def test_no_speed_makes_rows_dependent(small_problem: GaitProblem, speed: float) -> None:
    """A speed that no robot walks must fail in the solver, with the rows that it violates, not here."""
    program = build_program(replace(small_problem, speed=speed))
    require_full_rank(*on_coarse_mesh(program, initial_guess(program.problem, program.layout)))


def test_a_shorter_step_is_tried_where_rows_look_dependent(
    small_program: GaitProgram, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A long step may leave the range of a phase; rows that depend on each other do so at every step."""
    inside = np.clip(np.zeros(small_program.lower.size), small_program.lower, small_program.upper)
    found: list[float] = []

    def measured(program: GaitProgram, variables: np.ndarray) -> tuple[float, np.ndarray]:
        found.append(float(np.abs(variables - inside).max()))
        equal = int((program.program.lower == program.program.upper).sum())
        return (1e-3 if found[-1] < limit else 1e-9), np.zeros(equal)

    monkeypatch.setattr("amble.synthesis.rank.smallest_singular_value", measured)
    limit = 0.01
    assert require_full_rank(small_program, inside) == 1e-3
    assert len(found) == 2
    limit = 0.0
    with pytest.raises(NotSolvedError, match="equality rows depend on each other"):
        require_full_rank(small_program, inside)
