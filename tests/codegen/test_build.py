"""Compiled functions equal interpreted ones; the cache survives what happens to files."""

from __future__ import annotations

import logging
import multiprocessing
import sys
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from amble.codegen import build, cache, cache_folder, compile_all, compile_many, compiled, compiler
from amble.codegen.compiler import Compiler
from amble.errors import InputError, UnknownNameError, WorkError

needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler on this machine")


@pytest.fixture(autouse=True)
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Give every test its own cache folder and forget the notices that were given."""
    monkeypatch.setenv("AMBLE_CACHE", str(tmp_path / "cache"))
    monkeypatch.delenv("AMBLE_COMPILER", raising=False)
    build._notice_interpreted.cache_clear()
    cache.fallback_folder.cache_clear()
    return tmp_path / "cache"


def swing(name: str = "swing", shift: float = 0.0) -> ca.Function:
    """A function with sines, a sparse second output and a parameter."""
    state, force = ca.SX.sym("state", 4), ca.SX.sym("force")
    rate = ca.vertcat(state[2:], -ca.sin(state[:2]) * force + ca.cos(state[0] - state[1]) + shift)
    sparse = ca.SX(3, 3)
    sparse[0, 1], sparse[2, 2] = state[0] ** 3, ca.exp(force)
    return ca.Function(name, [state, force], [rate, sparse], ["state", "force"], ["rate", "sparse"])


def warnings_of(caplog: pytest.LogCaptureFixture) -> int:
    return sum(record.levelno >= logging.WARNING for record in caplog.records)


def libraries(folder: Path) -> list[Path]:
    return sorted(folder.glob("*.so"))


def assert_equal_functions(left: ca.Function, right: ca.Function, seed: int = 0) -> None:
    """Compare two functions of one signature at ten random inputs, bit for bit up to the compiler's rounding."""
    random = np.random.default_rng(seed)
    for _ in range(10):
        arguments = [ca.DM(left.sparsity_in(i), random.normal(size=left.nnz_in(i))) for i in range(left.n_in())]
        for a, b in zip(left.call(arguments), right.call(arguments), strict=True):
            assert a.sparsity() == b.sparsity()
            # the same operations in the same order; libm may differ from the interpreter's in the last bit
            np.testing.assert_allclose(np.array(a.nonzeros()), np.array(b.nonzeros()), rtol=1e-14, atol=1e-15)


@needs_compiler
def test_compiled_equals_interpreted() -> None:
    function = swing()
    native = compiled(function)
    assert native.class_name() == "External"
    assert native.name_in() == function.name_in()
    assert native.name_out() == function.name_out()
    assert_equal_functions(function, native)


@needs_compiler
@pytest.mark.parametrize("prefix", ["jac", "adj1", "fwd1", "jac_adj1"])
def test_derivatives_are_native_and_equal(prefix: str) -> None:
    function = swing()
    native = compiled(function, ["jac", "adj1", "fwd1", "jac_adj1"])
    expected, found = build.derivative(function, prefix), build.derivative(native, prefix)
    assert found.class_name() == "External"
    assert_equal_functions(expected, found)


@needs_compiler
def test_several_functions_share_a_file(empty_cache: Path) -> None:
    functions = [swing("first"), swing("second", shift=1.0)]
    native = compile_many(functions, "pair")
    assert list(native) == ["first", "second"]
    assert len(libraries(empty_cache)) == 1
    for function in functions:
        assert_equal_functions(function, native[function.name()])


@needs_compiler
def test_several_files_at_once(empty_cache: Path) -> None:
    sources = {f"file{i}": [swing(f"swing{i}", shift=i)] for i in range(3)}
    native = compile_all(sources, {"file1": ["jac"]})
    assert len(libraries(empty_cache)) == 3
    assert native["file1"]["swing1"].jacobian().class_name() == "External"
    for name, functions in sources.items():
        assert_equal_functions(functions[0], native[name][functions[0].name()])


@needs_compiler
def test_second_call_does_not_compile(empty_cache: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.INFO, "amble"):
        compiled(swing())
        assert "compiling swing ..." in caplog.text
        caplog.clear()
        before = [path.stat().st_mtime_ns for path in libraries(empty_cache)]
        compiled(swing())
    assert caplog.text == ""
    assert [path.stat().st_mtime_ns for path in libraries(empty_cache)] == before


@needs_compiler
def test_a_changed_function_is_another_entry(empty_cache: Path) -> None:
    assert_equal_functions(swing(shift=0.5), compiled(swing(shift=0.5)))
    assert_equal_functions(swing(shift=0.25), compiled(swing(shift=0.25)))
    compiled(swing(shift=0.25), ["jac"])
    assert len(libraries(empty_cache)) == 3


@needs_compiler
def test_another_compiler_version_is_another_entry() -> None:
    unit = build.Unit("swing", (swing(),), ())
    assert unit.key(Compiler("/usr/bin/cc", "12.1")) != unit.key(Compiler("/usr/bin/cc", "12.2"))


@needs_compiler
@pytest.mark.parametrize("damage", ["empty", "truncated", "one byte"])
def test_damaged_library_is_rebuilt(empty_cache: Path, damage: str) -> None:
    compiled(swing())
    (library,) = libraries(empty_cache)
    data = library.read_bytes()
    replacement = {
        "empty": b"",
        "truncated": data[: len(data) // 2],
        "one byte": data[:5000] + bytes([data[5000] ^ 1]) + data[5001:],
    }[damage]
    library.unlink()
    library.write_bytes(replacement)
    assert_equal_functions(swing(), compiled(swing()))
    assert cache.intact(library)


def compile_in_child(number: int) -> float:
    """Compile the shared function in another process and evaluate it there."""
    return float(compiled(swing())([0.1, 0.2, 0.3, 0.4], number)[0][2])


@needs_compiler
def test_concurrent_processes_share_the_cache(empty_cache: Path) -> None:
    context = multiprocessing.get_context("spawn")
    with context.Pool(4) as pool:
        values = pool.map(compile_in_child, range(8), chunksize=1)
    expected = [float(swing()([0.1, 0.2, 0.3, 0.4], number)[0][2]) for number in range(8)]
    np.testing.assert_allclose(values, expected, rtol=1e-14)
    assert len(libraries(empty_cache)) == 1
    assert not list(empty_cache.glob(".amble-*"))


def test_without_compiler_the_function_is_interpreted_and_said_once(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "none")
    assert compiler() is None
    function = swing()
    assert compiled(function, ["jac"]) is function
    compiled(function)
    assert warnings_of(caplog) == 1
    assert "interpreted" in caplog.text


@needs_compiler
def test_cache_that_cannot_be_written_falls_back(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    obstacle = tmp_path / "file"
    obstacle.write_text("not a folder")
    monkeypatch.setenv("AMBLE_CACHE", str(obstacle / "cache"))
    assert_equal_functions(swing(), compiled(swing()))
    compiled(swing())
    assert warnings_of(caplog) == 1
    assert "temporary folder" in caplog.text


@needs_compiler
def test_full_disk_while_compiling_falls_back(
    monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture, empty_cache: Path
) -> None:
    real = Compiler.build

    def full(tool: Compiler, source: Path, library: Path, names: Sequence[str]) -> None:
        if empty_cache in source.parents:
            raise OSError(28, "No space left on device")
        real(tool, source, library, names=names)

    monkeypatch.setattr(Compiler, "build", full)
    assert_equal_functions(swing(), compiled(swing()))
    assert "No space left on device" in caplog.text
    assert not libraries(empty_cache)


def test_full_disk_everywhere_is_interpreted(monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture) -> None:
    def full(*_: object, **__: object) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(build, "compiler", lambda: Compiler("/usr/bin/cc", "test"))
    monkeypatch.setattr(Compiler, "build", full)
    function = swing()
    assert compiled(function) is function
    assert "interpreted" in caplog.text


@needs_compiler
def test_compiler_failure_shows_its_messages(tmp_path: Path) -> None:
    tool = compiler()
    assert tool is not None
    source = tmp_path / "broken.c"
    source.write_text("int f( { return 1; }")
    with pytest.raises(WorkError, match=r"(?s)failed on broken\.c.*error"):
        tool.build(source, tmp_path / "broken.so")


def test_unknown_compiler_is_refused(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_COMPILER", "no-such-compiler")
    with pytest.raises(InputError, match="no-such-compiler"):
        compiled(swing())


def test_unknown_derivative_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="known: jac, adj1, fwd1"):
        compiled(swing(), ["hess"])


def test_unknown_file_in_derivatives_is_refused() -> None:
    with pytest.raises(UnknownNameError, match="known: file"):
        compile_all({"file": [swing()]}, {"fil": ["jac"]})


def test_functions_of_one_file_need_different_names() -> None:
    with pytest.raises(InputError, match="share a name"):
        compile_many([swing(), swing(shift=1.0)], "pair")


def test_cache_folder_follows_the_environment(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    assert cache_folder() == tmp_path / "cache"
    monkeypatch.delenv("AMBLE_CACHE")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "xdg"))
    assert cache_folder() == tmp_path / "xdg" / "amble"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path / "home"))
    assert cache_folder() == tmp_path / "home" / ".cache" / "amble"


def test_another_system_than_posix_is_refused_in_one_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(sys.modules["amble.codegen.compiler"], "POSIX", False)
    with pytest.raises(WorkError, match="amble runs on POSIX systems only"):
        compiled(swing())
