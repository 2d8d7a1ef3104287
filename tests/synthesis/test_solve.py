"""IPOPT with either linear solver: the same optimum, and the report of what solved its systems, and why."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.synthesis import program as program_module
from amble.synthesis.initial_guess import initial_guess
from amble.synthesis.program import GaitProgram, build_program
from amble.synthesis.solve import SOLVERS, Start, ipopt, ipopt_mumps, ipopt_structured


def _start(program: GaitProgram) -> Start:
    return Start(initial_guess(program.problem, program.layout) / program.layout.scale)


def test_both_linear_solvers_find_the_same_optimum_from_the_same_start(small_program: GaitProgram) -> None:
    """Both end at 1e-8 of the scaled problem, where the objective has as many digits; a neighbour is a warm start."""
    start = _start(small_program)
    ours, mumps = ipopt(small_program, start), ipopt_mumps(small_program, start)
    assert ours.solved
    assert mumps.solved
    assert (ours.report.linear_solver, mumps.report.linear_solver) == ("structured", "MUMPS")
    assert ours.report.objective == pytest.approx(mumps.report.objective, rel=1e-7)
    np.testing.assert_allclose(ours.variables, mumps.variables, atol=1e-4)  # the optimum is flat in some directions
    again = ipopt(small_program, Start(mumps.variables, mumps.multipliers))
    assert again.solved
    assert again.report.linear_solver == "structured"
    assert again.report.iterations < ours.report.iterations / 2


def test_both_are_solvers_by_name() -> None:
    assert SOLVERS["ipopt"] is ipopt
    assert SOLVERS["ipopt mumps"] is ipopt_mumps


def test_without_a_compiler_mumps_solves(small_program: GaitProgram, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    found = ipopt(small_program, _start(small_program), most_iterations=1)
    assert found.report.linear_solver == "MUMPS (no C compiler found)"


def test_unknowns_without_rows_leave_it_to_mumps(small_program: GaitProgram) -> None:
    """Rows of a law that count as another kind."""
    nlp = small_program.program
    kinds = np.where(nlp.row_kinds == "law", "period", nlp.row_kinds)
    found = ipopt(replace(small_program, program=replace(nlp, row_kinds=kinds)), _start(small_program), 1e-8, 1)
    assert found.report.linear_solver == "MUMPS (rows and unknowns of a node or an interval do not pair)"


def test_a_refusal_on_the_way_begins_again_with_mumps(
    small_program: GaitProgram, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A row stands twice: IPOPT finds the matrix singular and regularises its rows, which MUMPS takes."""
    problem, layout = small_program.problem, small_program.layout
    blocks = program_module._blocks(problem, layout)
    twice = [*blocks, replace(blocks[-1], name="again")]
    monkeypatch.setattr(program_module, "_blocks", lambda *_: twice)
    monkeypatch.setattr(program_module, "_written_once", program_module._written_once.__wrapped__)  # nothing kept
    program = build_program(problem)
    alone = ipopt_structured(program, _start(small_program), most_iterations=3)
    assert alone.refused == "IPOPT regularises the equality rows"
    assert not alone.solved
    found = ipopt(program, _start(small_program), most_iterations=3)
    assert (found.report.linear_solver or "").startswith("MUMPS (")
    np.testing.assert_array_equal(found.variables, ipopt_mumps(program, _start(program), most_iterations=3).variables)
