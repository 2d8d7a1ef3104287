"""A specification is read once, and its problem solved as it says."""

from __future__ import annotations

from dataclasses import replace
from importlib import resources
from pathlib import Path
from types import SimpleNamespace

import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.residual import Residual
from amble.synthesis import GaitProblem, synthesize
from amble.synthesis.specification import SolverSection, read_specification
from amble.verification.residuals import CheckReport
from amble.workflow import specified
from amble.workflow.specified import (
    NEAR_RECORD,
    Checked,
    GaitNotCheckedError,
    PosedProblem,
    missed_orbit,
    pose,
    solve,
    synthesize_specification,
    until_checked,
)


def test_a_file_and_what_was_read_from_it_pose_the_same_problem() -> None:
    with resources.as_file(resources.files("amble.specifications") / "astro-amble.toml") as path:
        file, read = pose(path), pose(read_specification(path))
    assert pose(None) == file
    assert file.name == "astro-amble.toml"
    assert (read.problem, read.solver) == (file.problem, file.solver)


def test_a_missing_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be read"):
        synthesize_specification(tmp_path / "none.toml")


@pytest.mark.parametrize("refinement", [1, 3])
def test_the_solver_settings_of_the_specification_are_used(refinement: int, monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[object] = []
    coarse = SimpleNamespace(outputs=pose(None).problem.outputs)
    monkeypatch.setattr(specified, "synthesize", lambda *arguments, **_: given.extend(arguments[2:4]) or coarse)
    monkeypatch.setattr(specified, "refine", lambda _, gait, factor, __: (gait, factor))
    with resources.as_file(resources.files("amble.specifications") / "astro-amble.toml") as path:
        read = read_specification(path)
    solver = read.solver.model_copy(update={"tolerance": 1e-5, "iterations": 7, "refinement": refinement})
    found = synthesize_specification(read.model_copy(update={"solver": solver}))
    assert given == [1e-5, 7]
    assert found == (coarse if refinement == 1 else (coarse, 3))


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
    assert missed_orbit(found.gait) < min(NEAR_RECORD, missed_orbit(coarse))


@pytest.mark.parametrize("passes", [True, False])
def test_a_mesh_is_made_finer_until_the_orbit_is_the_recorded_one(
    passes: bool, problem: GaitProblem, coarse: Gait, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    """Gaits that passed their check were stabilised and then refused: the error of the mesh had been magnified."""
    finer = replace(coarse, speed=2.0 * coarse.speed)
    missed = {coarse.speed: 2.0 * NEAR_RECORD, finer.speed: 0.5 * NEAR_RECORD}

    def checked(gait: Gait, factor: int, _: object) -> Checked:
        failed = () if passes or gait is coarse else (Residual("friction", 0.0, 0.7, 0.6, kind="friction"),)
        return Checked(gait=gait, report=CheckReport(failed, 1, 1e-5), factor=factor)

    monkeypatch.setattr(specified, "_checked", checked)
    monkeypatch.setattr(specified, "missed_orbit", lambda gait, _: missed[gait.speed])
    monkeypatch.setattr(specified, "synthesize", lambda *_, **__: finer)
    monkeypatch.setattr(specified, "refine", lambda *_: finer)
    found = until_checked(problem, coarse)
    assert found.passed
    assert found.gait is (finer if passes else coarse)
    assert ("to 8 intervals a domain, until the closed loop's own orbit was the gait's" in caplog.text) == passes


def test_what_no_mesh_mends_is_said(problem: GaitProblem, coarse: Gait, caplog: pytest.LogCaptureFixture) -> None:
    """Feet that swing higher than legs are long."""
    higher = replace(coarse, limits=replace(coarse.limits, clearance=1.0))
    found = until_checked(replace(problem, limits=higher.limits), higher, most_iterations=3)
    assert not found.passed
    assert found.gait is higher
    assert "no gait was found on 2 times the intervals" in caplog.text
    assert "the gait does not pass its check" in caplog.text


def test_a_gait_that_fails_its_check_on_every_mesh_is_not_called_done(
    problem: GaitProblem, coarse: Gait, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It was handed out with a warning and exit code 0."""
    higher = replace(coarse, limits=replace(coarse.limits, clearance=1.0))
    monkeypatch.setattr(specified, "synthesize", lambda *_, **__: higher)
    monkeypatch.setattr(specified, "refine", lambda *_, **__: higher)
    posed = PosedProblem("from a test", replace(problem, limits=higher.limits), SolverSection())
    with pytest.raises(
        GaitNotCheckedError, match=r"fails its check on 4 to 16 intervals a domain: \d+ of \d+ rows"
    ) as caught:
        solve(posed)
    assert caught.value.exit_code == 1
    assert caught.value.last is higher
    assert "[limits] node_margins = true" in str(caught.value)
