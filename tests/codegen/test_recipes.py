"""Libraries whose functions follow from others by a rule."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.codegen import Recipe, compile_recipes
from amble.codegen.build import BREAK_EVEN


@pytest.fixture
def cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("AMBLE_CACHE", str(tmp_path))
    return tmp_path


def _recipe(power: int, built: list[int], rule: str = "slope-1") -> Recipe:
    x = ca.SX.sym("x", 2)
    seed = ca.Function("f", [x], [ca.sum1(x**power)])

    def derive() -> Sequence[ca.Function]:
        built.append(power)
        return [ca.Function("slope", [x], [ca.gradient(seed(x), x)])]

    return Recipe((seed,), rule, ("slope",), derive)


def test_what_is_cached_is_not_built_again(cache: Path) -> None:
    built: list[int] = []
    for _ in range(2):
        slope = compile_recipes({"unit": _recipe(3, built)})["unit"]["slope"]
        np.testing.assert_allclose(np.asarray(slope([1.0, 2.0])).ravel(), [3.0, 12.0])
    assert built == [3]
    assert len(list(cache.glob("unit-*.so"))) == 1


def test_another_seed_or_rule_is_another_library(cache: Path) -> None:
    built: list[int] = []
    for power, rule in ((3, "slope-1"), (2, "slope-1"), (3, "slope-2")):
        compile_recipes({"unit": _recipe(power, built, rule)})
    assert built == [3, 2, 3]
    assert len(list(cache.glob("unit-*.so"))) == 3


def test_without_a_compiler_the_rule_is_interpreted(cache: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    built: list[int] = []
    slope = compile_recipes({"unit": _recipe(2, built)})["unit"]["slope"]
    np.testing.assert_allclose(np.asarray(slope([1.0, 2.0])).ravel(), [2.0, 4.0])
    assert built == [2]
    assert not list(cache.iterdir())


@pytest.mark.parametrize(("evaluations", "libraries"), [(BREAK_EVEN - 1, 0), (BREAK_EVEN, 1)])
def test_what_is_evaluated_seldom_is_interpreted_unless_it_is_cached(
    cache: Path, evaluations: float, libraries: int
) -> None:
    built: list[int] = []
    recipes = {"unit": _recipe(3, built)}
    for _ in range(2):
        slope = compile_recipes(recipes, {"unit": evaluations})["unit"]["slope"]
        np.testing.assert_allclose(np.asarray(slope([1.0, 2.0])).ravel(), [3.0, 12.0])
    assert len(list(cache.glob("unit-*.so"))) == libraries
    assert built == [3] * (1 if libraries else 2)
    compile_recipes(recipes)
    assert "External" in compile_recipes(recipes, {"unit": 1.0})["unit"]["slope"].class_name()


def test_a_function_whose_evaluations_are_not_told_is_compiled(cache: Path) -> None:
    compile_recipes({"seldom": _recipe(3, []), "unit": _recipe(2, [])}, {"seldom": 1.0})
    assert [path.name.split("-")[0] for path in cache.glob("*.so")] == ["unit"]
