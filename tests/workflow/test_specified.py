"""A specification is read once, and its problem solved as it says."""

from __future__ import annotations

from importlib import resources
from pathlib import Path

import pytest

from amble.errors import InputError
from amble.synthesis.specification import read_specification
from amble.workflow import specified
from amble.workflow.specified import pose, synthesize_specification


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
    monkeypatch.setattr(specified, "synthesize", lambda *arguments, **_: given.extend(arguments[2:4]) or "coarse")
    monkeypatch.setattr(specified, "refine", lambda _, gait, factor, __: (gait, factor))
    with resources.as_file(resources.files("amble.specifications") / "astro-amble.toml") as path:
        read = read_specification(path)
    solver = read.solver.model_copy(update={"tolerance": 1e-5, "iterations": 7, "refinement": refinement})
    found = synthesize_specification(read.model_copy(update={"solver": solver}))
    assert given == [1e-5, 7]
    assert found == ("coarse" if refinement == 1 else ("coarse", 3))
