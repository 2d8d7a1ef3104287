"""Temporary folders beside what they are for, which the next run removes where a process died in one.

A folder is locked as long as its process lives: the system takes the lock back from a process that was killed, so a
folder that can be locked has no owner any more.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import os
import shutil
from collections.abc import Iterator
from pathlib import Path

try:
    import fcntl
except ImportError:  # a system without advisory locks: what a killed process left stays
    fcntl = None  # type: ignore[assignment]

PREFIX = ".amble-"

_OPEN = os.O_RDONLY | getattr(os, "O_DIRECTORY", 0) | getattr(os, "O_NOFOLLOW", 0)


@contextlib.contextmanager
def workplace(parent: Path) -> Iterator[Path]:
    """Yield a new folder in ``parent`` that only this user can enter; it is gone when the block ends.

    Raises:
        OSError: where it cannot be made.
    """
    sweep(parent)
    folder, lock = _locked(parent)
    try:
        yield folder
    finally:
        shutil.rmtree(folder, ignore_errors=True)
        if lock is not None:
            os.close(lock)


@functools.cache
def kept_workplace(parent: Path) -> Path:
    """Make a folder in ``parent`` that lives as long as this process."""
    stack = contextlib.ExitStack()
    folder = stack.enter_context(workplace(parent))
    atexit.register(stack.close)
    return folder


def sweep(parent: Path) -> None:
    """Remove what dead processes of this user left in a folder; what cannot be removed stays."""
    if fcntl is None:
        return
    try:
        with os.scandir(parent) as entries:
            found = [Path(entry.path) for entry in entries if entry.name.startswith(PREFIX)]
    except OSError:
        return
    for folder in found:
        with contextlib.suppress(OSError):
            _remove_if_dead(folder)


def _remove_if_dead(folder: Path) -> None:
    lock = os.open(folder, _OPEN)
    try:
        if os.fstat(lock).st_uid == os.geteuid():
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
            shutil.rmtree(folder, ignore_errors=True)
    finally:
        os.close(lock)


def _locked(parent: Path) -> tuple[Path, int | None]:
    """Make a folder and lock it; again where another process swept it in between."""
    while True:
        folder = parent / f"{PREFIX}{os.urandom(6).hex()}"
        folder.mkdir(mode=0o700)
        if fcntl is None:
            return folder, None
        try:
            lock = os.open(folder, _OPEN)
        except FileNotFoundError:
            continue
        with contextlib.suppress(OSError):  # a file system without locks: nobody can sweep there either
            fcntl.flock(lock, fcntl.LOCK_EX)
        if folder.exists():
            return folder, lock
        os.close(lock)
