"""Functions in casadi's C interface: right numbers while they come and go, and nothing left behind."""

from __future__ import annotations

import gc
import tempfile
from collections.abc import Iterator
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.codegen import compiled, compiler
from amble.simulation import bound as bound_module
from amble.simulation import casadi_c
from amble.simulation.bound import Bound, bind
from amble.simulation.flow import FlowDefinition
from amble.simulation.native import prepare

pytestmark = pytest.mark.skipif(
    compiler() is None or casadi_c.interface() is None, reason="no C compiler, or no C interface of casadi"
)
CLOCKS, STATES = np.linspace(0.0, 1.0, 4), np.random.default_rng(0).normal(size=(4, 2))


def function(factor: float, name: str = "scaled") -> ca.Function:
    t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2), ca.SX.sym("p")
    return ca.Function(name, [t, x, p], [factor * x * ca.sin(t + p)], ["t", "x", "p"], ["rate"])


def held() -> int:
    gc.collect()
    library = casadi_c.interface()
    assert library is not None
    return int(library.casadi_c_n_loaded())


@pytest.fixture(autouse=True)
def nothing_is_left() -> Iterator[None]:
    """The list is after the test as long as before; what other tests still use stays below."""
    casadi_c._recent.clear()
    before = held()
    yield
    casadi_c._recent.clear()
    assert held() <= before  # others may give theirs back meanwhile


def assert_scales(bound: Bound, factor: float, parameter: float) -> None:
    (found,) = bound.along(CLOCKS, STATES)
    assert bound.callee is not None
    np.testing.assert_allclose(found, factor * STATES * np.sin(CLOCKS + parameter)[:, None], rtol=1e-15)


def test_functions_come_and_go_in_any_order() -> None:
    generator, alive, before = np.random.default_rng(3), {}, held()
    for number in range(100):
        alive[number] = bind(function(float(number)), np.array([0.1 * number]))
        assert_scales(alive[number], float(number), 0.1 * number)
        for gone in generator.permutation(sorted(alive))[12:]:
            del alive[int(gone)]
        for each, bound in alive.items():
            assert_scales(bound, float(each), 0.1 * each)
    assert held() - before > 12  # those that are kept for later, and free places below them
    casadi_c._recent.clear()
    assert 0 < held() - before <= 100
    for each, bound in alive.items():
        assert_scales(bound, float(each), 0.1 * each)


def test_the_list_stays_short_where_each_function_is_used_once() -> None:
    before, most = held(), 0
    library = casadi_c.interface()
    assert library is not None
    for number in range(3 * casadi_c.RECENT):
        assert_scales(bind(function(float(number)), np.zeros(1)), float(number), 0.0)
        most = max(most, int(library.casadi_c_n_loaded()) - before)
    assert most == casadi_c.RECENT


def test_one_function_serves_many_with_parameters_of_their_own() -> None:
    before = held()
    bounds = [bind(function(2.0), np.array([float(number)])) for number in range(5)]
    for number, bound in enumerate(bounds):
        assert_scales(bound, 2.0, float(number))
    for number, bound in enumerate(bounds):
        assert_scales(bound, 2.0, float(number))
    assert held() == before + 1


def test_another_file_that_cannot_be_loaded_is_no_obstacle(capfd: pytest.CaptureFixture[str]) -> None:
    library, before = casadi_c.interface(), held()
    assert library is not None
    kept = bind(function(3.0), np.zeros(1))
    assert_scales(kept, 3.0, 0.0)
    assert library.casadi_c_push_file(b"/no/such/file") != 0
    assert "no/such/file" in capfd.readouterr().err
    del kept
    casadi_c._recent.clear()
    assert held() == before


def test_a_library_that_is_gone_from_the_cache_is_still_loaded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_CACHE", str(tmp_path / "cache"))
    native = compiled(function(4.0, "vanishes"))
    for library in (tmp_path / "cache").glob("vanishes*.so"):
        library.unlink()
    monkeypatch.setenv("AMBLE_CACHE", str(tmp_path / "other"))
    assert_scales(bind(native, np.zeros(1)), 4.0, 0.0)


def test_without_a_place_for_the_file_python_does_the_work(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    before = held()
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path / "missing"))
    bound = bind(function(6.0), np.zeros(1))
    (found,) = bound.along(CLOCKS, STATES)
    assert bound.callee is None
    np.testing.assert_allclose(found, 6.0 * STATES * np.sin(CLOCKS)[:, None], rtol=1e-15)
    assert held() == before


def test_without_the_interface_nothing_is_native(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(bound_module, "loaded", lambda _: None)
    bound = bind(function(5.0), np.zeros(1))
    (found,) = bound.along(CLOCKS, STATES)
    assert bound.callee is None
    np.testing.assert_allclose(found, 5.0 * STATES * np.sin(CLOCKS)[:, None], rtol=1e-15)
    assert prepare(FlowDefinition(function(1.0), np.zeros(1), ())) is None
