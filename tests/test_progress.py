"""The one record of progress, on one line."""

from __future__ import annotations

import ast
import inspect
from collections.abc import Callable
from pathlib import Path

import pytest

import amble
from amble.progress import ProgressReport


@pytest.mark.parametrize(
    ("report", "line"),
    [
        (ProgressReport(what="closed loop"), "closed loop"),
        (ProgressReport(what="cycle", done=2, of=5), "cycle 2 of 5"),
        (ProgressReport(what="iteration", done=7, quantity="objective", value=120.25), "iteration 7, objective 120.2"),
        (ProgressReport(what="step", done=0, of=1, detail="worst row 'a'"), "step 0 of 1, worst row 'a'"),
        (ProgressReport(what="wrote", file=Path("gait.json")), "wrote gait.json"),
    ],
)
def test_a_report_is_one_line(report: ProgressReport, line: str) -> None:
    assert str(report) == line


def test_there_is_one_kind_of_progress_in_the_whole_library() -> None:
    """Whatever takes a callback takes this one, under this name."""
    source = Path(__file__).parents[1] / "src" / "amble"
    found = 0
    for path in source.rglob("*.py"):
        tree = ast.parse(path.read_text(encoding="utf-8"))
        for node in ast.walk(tree):
            if isinstance(node, ast.arg) and node.arg in ("progress", "tell", "doing", "callback"):
                assert node.annotation is not None, (path, node.lineno)
                assert ast.unparse(node.annotation) in ("Progress", "Progress | None"), (path, node.lineno)
                found += 1
            if isinstance(node, ast.ImportFrom) and any(alias.name == "Progress" for alias in node.names):
                assert node.module == "amble.progress", (path, node.lineno)
    assert found > 20


LONG = (amble.assess, amble.certify, amble.check, amble.fixed_point, amble.refine, amble.reproduce, amble.simulate,
        amble.stabilize, amble.sweep, amble.synthesize, amble.synthesize_specification)  # fmt: skip


@pytest.mark.parametrize("function", LONG, ids=lambda function: function.__name__)
def test_what_takes_long_tells_how_far_it_is(function: Callable[..., object]) -> None:
    parameter = inspect.signature(function).parameters["progress"]
    assert parameter.annotation == "Progress | None"
    assert parameter.default is None
