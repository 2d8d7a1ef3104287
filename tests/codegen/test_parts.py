"""Functions that are compiled in parts give the same numbers, bit for bit."""

from __future__ import annotations

import shutil
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiler
from amble.codegen.parts import cut_into_parts

INPUTS, OUTPUTS = 12, 40


def long_function(statements: int, seed: int = 0) -> ca.Function:
    """Random sums, products, sines and branches whose operands lie near and far back."""
    random = np.random.default_rng(seed)
    x, y = ca.SX.sym("x", INPUTS), ca.SX.sym("y")
    values = [y, *ca.vertsplit(x)]
    for number in range(statements):
        first, second = (values[random.integers(max(0, len(values) - reach), len(values))] for reach in (20, 2000))
        values.append(
            [first * second, first + second, ca.sin(first) - second, ca.if_else(first > 0, second, y)][number % 4]
        )
    return ca.Function("straight", [x, y], [ca.vertcat(*values[-OUTPUTS:]), values[len(values) // 2]])


def source(function: ca.Function) -> str:
    generator = ca.CodeGenerator("straight.c", {"with_header": False})
    generator.add(function)
    return str(generator.dump())


@pytest.mark.skipif(compiler() is None, reason="no C compiler on this machine")
@pytest.mark.parametrize("size", [7, 300, pytest.param(100, marks=pytest.mark.slow)])
@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_parts_equal_the_whole(tmp_path: Path, size: int, seed: int) -> None:
    function = long_function(1300, seed)
    text = cut_into_parts(source(function), [function], size)
    assert text.count("noinline") > 2
    tool = compiler()
    assert tool is not None
    found = []
    for name, content in (("whole", source(function)), ("parts", text)):
        (tmp_path / f"{name}.c").write_text(content)
        tool.build(tmp_path / f"{name}.c", tmp_path / f"{name}.so")
        found.append(ca.external("straight", str(tmp_path / f"{name}.so")))
    random = np.random.default_rng(seed)
    for _ in range(5):
        arguments = [random.normal(size=INPUTS), random.normal()]
        whole, parts = (np.vstack([np.array(value) for value in native.call(arguments)]) for native in found)
        assert np.array_equal(whole, parts, equal_nan=True)
        assert np.isfinite(whole).any()


def test_short_functions_stay_as_they_are() -> None:
    function = long_function(50)
    text = source(function)
    assert cut_into_parts(text, [function]) == text


def test_functions_with_calls_stay_as_they_are() -> None:
    """A function of matrix operations is not straight-line code."""
    x = ca.MX.sym("x", 3, 3)
    function = ca.Function("matrix", [x], [ca.mtimes(x, x), ca.inv(x)])
    text = source(function)
    assert cut_into_parts(text, [function], 2) == text


@pytest.mark.parametrize(
    ("now", "then"),
    [
        ("static int casadi_f0(", "static inline int casadi_f0("),
        ("  if (res[", "  if (0 != res["),
        ("  return 0;", "  return CASADI_SUCCESS;"),
    ],
)
def test_another_form_of_the_c_text_is_told(now: str, then: str, caplog: pytest.LogCaptureFixture) -> None:
    """A change of casadi's C was silent: a long function then took minutes to compile."""
    function = long_function(1300)
    text = source(function)
    cut_into_parts(text, [function], 100)
    assert not caplog.records
    assert now in text
    changed = text.replace(now, then)
    assert cut_into_parts(changed, [function], 100) == changed
    assert "(straight) 0 are compiled in parts" in caplog.text


@pytest.mark.skipif(shutil.which("gcc") is None, reason="no gcc on this machine")
def test_parts_are_warning_free(tmp_path: Path) -> None:
    tool = compiler()
    assert tool is not None
    function = long_function(1000)
    (tmp_path / "straight.c").write_text(cut_into_parts(source(function), [function], 100))
    flags = ("-O1", "-fPIC", "-shared", "-std=c99", "-Wall", "-Werror", "-Wno-unused-function")
    tool.build(tmp_path / "straight.c", tmp_path / "straight.so", flags)
