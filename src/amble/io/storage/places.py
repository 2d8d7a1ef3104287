"""Where something may be written: links are followed, and what cannot be written is refused in one sentence.

A temporary folder lies beside what it is for and is locked as long as its process lives: the system takes the lock back
from a process that was killed, so a folder that can be locked has no owner any more, and the next run removes it.
"""

from __future__ import annotations

import atexit
import contextlib
import errno
import functools
import os
import shutil
import stat
from collections.abc import Iterator
from contextvars import ContextVar
from pathlib import Path

from amble.errors import InputError, WorkError, shown_path

USER_ERRORS = (
    errno.EACCES,
    errno.EPERM,
    errno.ENOTDIR,
    errno.EISDIR,
    errno.EROFS,
    errno.EEXIST,
    errno.ENAMETOOLONG,
    errno.ELOOP,
    errno.ENOENT,
    errno.EBUSY,
    errno.ENOTEMPTY,
)


try:
    import fcntl
except ImportError:  # a system without advisory locks: what a killed process left stays
    fcntl = None  # type: ignore[assignment]

PREFIX = ".amble-"

_CONFINED: ContextVar[tuple[Path, ...]] = ContextVar("confined", default=())
"""Folders that are written at the moment."""

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


def check_file(path: str | Path) -> None:
    """Refuse a file that could not be written, before the work whose result it is to hold; nothing is left there.

    Raises:
        InputError: where the place cannot be written.
        WorkError: where writing fails for another reason, such as a full disk.
    """
    target = file_at(path)
    with worded(path, target):
        _probe(target.parent, Path(path).name)


def check_folder(path: str | Path) -> None:
    """Refuse a folder in which no file could be written; see ``check_file``."""
    target = folder_at(path)
    with worded(path, target / "file"):
        _probe(target, "file")


def file_at(path: str | Path) -> Path:
    """Return the file that a path leads to, through links; it need not exist.

    Raises:
        InputError: where it cannot be a file: it is a folder or a device, or may not be overwritten.
    """
    target, mode = _followed(path)
    if mode is not None and stat.S_ISDIR(mode):
        raise InputError(f"cannot write '{shown_path(path)}': it is a folder; name a file")
    if mode is not None and not stat.S_ISREG(mode):
        raise InputError(f"cannot write '{shown_path(path)}': it exists and is not a regular file")
    if mode is not None and not os.access(target, os.W_OK):
        raise InputError(f"cannot write '{shown_path(path)}': it is protected against writing")
    return target


def folder_at(path: str | Path) -> Path:
    """Return the folder that a path leads to, through links; it need not exist.

    Raises:
        InputError: where something else is in its place.
    """
    target, mode = _followed(path)
    if mode is not None and not stat.S_ISDIR(mode):
        raise InputError(f"cannot write '{shown_path(path)}': it is not a folder")
    return target


@contextlib.contextmanager
def confined(folder: str | Path) -> Iterator[None]:
    """Refuse to write, while the block lasts, through a symbolic link that leads out of a folder.

    A folder from elsewhere, of a run or of a library, may hold a link in the place of a file that is written there. The
    folder itself, which somebody named, may be a link.

    Args:
        folder: what is written lies in it.
    """
    token = _CONFINED.set((*_CONFINED.get(), Path(folder)))
    try:
        yield
    finally:
        _CONFINED.reset(token)


def _check_confined(path: str | Path, target: Path) -> None:
    for folder in _CONFINED.get():
        if Path(os.path.abspath(path)).is_relative_to(os.path.abspath(folder)) and not target.is_relative_to(
            os.path.realpath(folder)
        ):
            raise InputError(
                f"cannot write '{shown_path(path)}': a symbolic link in '{shown_path(folder)}' leads out of it, to "
                f"'{shown_path(target)}'; remove the link"
            )


@contextlib.contextmanager
def worded(path: str | Path, target: Path) -> Iterator[None]:
    """Turn the errors of the system at a place into one sentence each.

    Raises:
        InputError: where the place cannot be written (a file in the way, no permission).
        WorkError: where writing fails for another reason, such as a full disk.
    """
    try:
        yield
    except OSError as error:
        # an error of another file, such as one that the block reads, is not ours to reword
        if error.filename is not None and not _ours(Path(os.fsdecode(error.filename)), target):
            raise
        kind = InputError if error.errno in USER_ERRORS else WorkError
        raise kind(f"cannot write '{shown_path(path)}': {error.strerror or error}") from error


def _ours(path: Path, target: Path) -> bool:
    return path in (target, *target.parents) or any(part.startswith(PREFIX) for part in path.parts)


def _followed(path: str | Path) -> tuple[Path, int | None]:
    """Return the end of a chain of links and its mode; no mode where there is nothing."""
    try:
        target = Path(os.path.realpath(path))
        _check_confined(path, target)
        try:
            return target, os.stat(target).st_mode
        except FileNotFoundError:
            return target, None
    except ValueError as error:  # NUL, or a character that no file name can hold
        raise InputError(f"cannot write {os.fspath(path)!r}: no file can have this name") from error
    except OSError as error:
        raise InputError(f"cannot write '{shown_path(path)}': {error.strerror or error}") from error


def _probe(folder: Path, name: str) -> None:
    """Make the missing folders and the file, all inside a temporary folder."""
    present = folder
    while not present.exists():
        present = present.parent
    with workplace(present) as work:
        place = work / folder.relative_to(present)
        place.mkdir(parents=True, exist_ok=True)
        (place / name).touch()
