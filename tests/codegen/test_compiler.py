"""Compilers that sleep, lie, or speak no UTF-8."""

from __future__ import annotations

import os
import sys
import threading
import time
from pathlib import Path

import pytest

from amble.codegen import build, cache, compiled, compiler
from amble.errors import InputError, WorkError
from tests.codegen.test_build import swing

module = sys.modules["amble.codegen.compiler"]
REAL = compiler()

pytestmark = pytest.mark.skipif(REAL is None, reason="no C compiler on this machine")


@pytest.fixture(autouse=True)
def empty_cache(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("AMBLE_CACHE", str(tmp_path / "cache"))
    build._notice_interpreted.cache_clear()
    cache.fallback_folder.cache_clear()
    return tmp_path / "cache"


@pytest.fixture
def impostor(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """A script that is named as the compiler."""
    script = tmp_path / "impostor"
    monkeypatch.setenv("AMBLE_COMPILER", str(script))
    return script


def behave(script: Path, at_work: str, version: str = "echo impostor 1.0") -> None:
    """Let it say its version, and else do something; OUT is where the library is wanted."""
    find = 'while [ "$1" != -o ]; do shift; done; OUT="$2"'
    script.write_text(f'#!/bin/sh\nif [ "$1" = --version ]; then {version}; exit; fi\n{find}\n{at_work}\n')
    script.chmod(0o700)


GARBAGE = {
    "nothing": "exit 0",
    "empty": ': > "$OUT"',
    "text": 'echo "not a library" > "$OUT"',
    "header only": 'head -c 100 /bin/sh > "$OUT"',
    "another library": f'echo "int other;" > "$OUT.c"; {REAL.path if REAL else "cc"} -shared -fPIC -o "$OUT" "$OUT.c"',
}


@pytest.mark.parametrize("kind", GARBAGE)
def test_garbage_with_exit_code_0_is_not_sealed(kind: str, impostor: Path, empty_cache: Path) -> None:
    behave(impostor, GARBAGE[kind])
    with pytest.raises(WorkError, match=r"reports success, but 'swing\.so' cannot be used") as failed:
        compiled(swing())
    assert len(str(failed.value).splitlines()) == 1
    assert not list(empty_cache.glob("*.so"))
    assert not list(empty_cache.glob(".amble-*"))


def test_a_folder_that_may_not_hold_libraries_is_an_error_of_the_place(
    impostor: Path, caplog: pytest.LogCaptureFixture, monkeypatch: pytest.MonkeyPatch
) -> None:
    """What the loader says where a folder is mounted noexec."""
    behave(impostor, f'echo "int swing;" > "$OUT.c"; {REAL.path if REAL else "cc"} -shared -fPIC -o "$OUT" "$OUT.c"')
    monkeypatch.setattr(module, "TRIAL", "raise OSError('x.so: failed to map segment from shared object')")
    assert compiled(swing()).class_name() == "SXFunction"
    assert "may not be run" in caplog.text


def test_a_compiler_that_sleeps_is_stopped_with_what_it_started(
    impostor: Path, empty_cache: Path, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    behave(impostor, f"sleep 600 & echo $! > {tmp_path}/pid; wait")
    monkeypatch.setattr(module, "BUILD_LIMIT", 1.0)
    monkeypatch.setattr(module, "BUILD_LIMIT_PER_BYTE", 0.0)
    started = time.monotonic()
    with pytest.raises(WorkError, match=r"took more than 1 s on swing\.c"):
        compiled(swing())
    assert time.monotonic() - started < 30
    assert not running(int((tmp_path / "pid").read_text()))
    assert not list(empty_cache.glob(".amble-*"))


def running(number: int) -> bool:
    """Whether a process does anything; one that nobody has asked for its exit code does not."""
    for _ in range(100):
        try:
            state = Path(f"/proc/{number}/stat").read_text().rpartition(")")[2].split()[0]
        except FileNotFoundError:
            return False
        if state == "Z":
            return False
        time.sleep(0.05)
    return True


def test_a_compiler_that_sleeps_over_its_version_is_refused(impostor: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    behave(impostor, "exit 1", version="sleep 600")
    monkeypatch.setattr(module, "VERSION_LIMIT", 0.5)
    with pytest.raises(InputError, match=r"does not tell its version within 0\.5 s"):
        compiler()


def test_a_sleeping_candidate_is_passed_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    behave(tmp_path / "cc", "exit 1", version="sleep 600")
    behave(tmp_path / "gcc", "exit 1", version="echo second")
    monkeypatch.delenv("AMBLE_COMPILER", raising=False)
    monkeypatch.setenv("PATH", f"{tmp_path}{os.pathsep}{os.environ['PATH']}")
    monkeypatch.setattr(module, "VERSION_LIMIT", 2.0)
    found = compiler()
    assert found is not None
    assert found.version == "second"
    assert f"{tmp_path}/cc does not tell its version" in caplog.text


def test_output_that_is_not_utf8(impostor: Path) -> None:
    behave(impostor, r"printf 'caf\351: broken\n' >&2; exit 3", version=r"printf 'caf\351 1.0\n'")
    found = compiler()
    assert found is not None
    assert found.version == "caf\ufffd 1.0"
    with pytest.raises(WorkError, match="caf\ufffd: broken"):
        compiled(swing())


def test_a_failure_stops_what_is_compiled_beside(impostor: Path, tmp_path: Path) -> None:
    (tmp_path / "first").touch()
    behave(impostor, 'case "$OUT" in */one.so) sleep 1; exit 1;; esac; sleep 600')
    started = time.monotonic()
    with pytest.raises(WorkError, match=r"failed on one\.c"):
        build.compile_all({"one": [swing("one")], "two": [swing("two")]})
    assert time.monotonic() - started < 30
    assert not module.STOP.is_set()


def test_who_waits_for_a_lock_gives_up_when_the_work_ends() -> None:
    folder = cache.writable_folder()
    ended: list[type[BaseException]] = []

    def wait() -> None:
        try:
            with cache.locked(folder, "key"):
                pass
        except KeyboardInterrupt as error:
            ended.append(type(error))

    with cache.locked(folder, "key"):
        thread = threading.Thread(target=wait)
        thread.start()
        module.STOP.set()
        thread.join(10)
    module.STOP.clear()
    assert ended == [KeyboardInterrupt]
