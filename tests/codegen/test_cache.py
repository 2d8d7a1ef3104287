"""Only what this user wrote is loaded, and what a killed process left is removed."""

from __future__ import annotations

import ctypes
import logging
import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import pytest

from amble.codegen import cache, compiler
from amble.errors import InputError

needs_compiler = pytest.mark.skipif(compiler() is None, reason="no C compiler on this machine")


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("AMBLE_CACHE", str(tmp_path / "cache"))
    cache.fallback_folder.cache_clear()
    cache._swept.cache_clear()
    return tmp_path / "cache"


def built(text: str = "int answer(void) { return 1; }", key: str = "key") -> int:
    """Answer of a library that is built where the cache has none."""
    tool = compiler()
    assert tool is not None

    def build(output: Path) -> None:
        source = output.with_suffix(".c")
        source.write_text(text)
        tool.build(source, output)

    library = cache.kept(cache.writable_folder() / f"unit-{key}.so", build)
    # by another name: the dynamic loader answers a path that it has loaded before from memory
    with tempfile.NamedTemporaryFile(suffix=".so") as copy:
        shutil.copy(library, copy.name)
        return int(ctypes.CDLL(copy.name).answer())


def mode(path: Path) -> int:
    return path.stat().st_mode & 0o777


@needs_compiler
@pytest.mark.parametrize("mask", [0o000, 0o002, 0o022])
def test_the_cache_is_closed_to_others_whatever_the_umask(folder: Path, mask: int) -> None:
    before = os.umask(mask)
    try:
        assert built() == 1
    finally:
        os.umask(before)
    assert mode(folder) == 0o700
    assert {path.suffix: mode(path) for path in folder.iterdir()} == {".so": 0o700, ".lock": 0o600}


@needs_compiler
@pytest.mark.parametrize("opened", [0o777, 0o1777, 0o770])
def test_a_cache_that_others_can_write_is_not_used(folder: Path, opened: int, caplog: pytest.LogCaptureFixture) -> None:
    assert built() == 1
    (planted,) = folder.glob("*.so")
    folder.chmod(opened)
    assert built("int answer(void) { return 2; }") == 2
    assert caplog.text.count("other users may write there") == 1
    assert planted.exists()


@needs_compiler
def test_a_cache_below_a_folder_that_others_can_write_is_not_used(
    tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    assert built() == 1
    tmp_path.chmod(0o777)
    assert built("int answer(void) { return 2; }") == 2
    assert f"every user may rename what is in {tmp_path}" in caplog.text


@needs_compiler
@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() != 0, reason="only root can give files away")
@pytest.mark.parametrize("which", ["folder", "library"])
def test_what_another_user_planted_is_not_loaded(folder: Path, which: str) -> None:
    assert built() == 1
    (planted,) = folder.glob("*.so")
    os.chown(folder if which == "folder" else planted, 65534, 65534)
    assert built("int answer(void) { return 2; }") == 2


@needs_compiler
@pytest.mark.parametrize("plant", ["writable", "link", "pipe"])
def test_a_planted_library_is_built_anew(folder: Path, tmp_path: Path, plant: str) -> None:
    assert built() == 1
    (planted,) = folder.glob("*.so")
    if plant == "writable":
        planted.chmod(0o777)
    else:
        planted.rename(tmp_path / "elsewhere.so")
        planted.symlink_to(tmp_path / "elsewhere.so") if plant == "link" else os.mkfifo(planted)
    assert built("int answer(void) { return 2; }") == 2
    assert mode(planted) == 0o700


@needs_compiler
@pytest.mark.parametrize("exists", [True, False])
def test_a_planted_lock_link_is_neither_followed_nor_truncated(folder: Path, tmp_path: Path, exists: bool) -> None:
    precious = tmp_path / "precious"
    if exists:
        precious.write_text("content")
    folder.mkdir(mode=0o700)
    (folder / "key.lock").symlink_to(precious)
    with pytest.raises(OSError, match="symbolic"):
        built()
    assert precious.exists() == exists
    assert not exists or precious.read_text() == "content"


@needs_compiler
def test_a_lock_is_not_truncated(folder: Path) -> None:
    folder.mkdir(mode=0o700)
    (folder / "key.lock").write_text("content")
    assert built() == 1
    assert (folder / "key.lock").read_text() == "content"


KILLED = """
import os, signal, sys
from pathlib import Path
from amble.codegen import cache

def build(output):
    output.write_bytes(b"half")
    os.kill(os.getpid(), signal.SIGKILL)

cache.kept(cache.writable_folder() / "unit-key.so", build)
"""


def test_the_build_folder_of_a_killed_process_is_swept(folder: Path) -> None:
    assert subprocess.run([sys.executable, "-c", KILLED], check=False).returncode < 0
    assert len(list(folder.glob(".amble-*"))) == 1
    cache.writable_folder()
    assert not list(folder.glob(".amble-*"))


def test_a_home_that_does_not_exist_is_a_sentence(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AMBLE_CACHE", "~nobody-of-this-name/cache")
    with pytest.raises(InputError, match="has no home folder"):
        cache.cache_folder()


def test_a_compiler_whose_path_is_not_utf8_has_a_key() -> None:
    assert cache.content_key(["/opt/\udce9/cc"]) != cache.content_key(["/opt/\udce8/cc"])


def test_a_sound_cache_stays_silent(folder: Path, caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.WARNING):
        assert cache.writable_folder() == folder
    assert caplog.text == ""
