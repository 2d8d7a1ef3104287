"""Where something may be written: links are followed, and what cannot be written is refused in one sentence."""

from __future__ import annotations

import contextlib
import errno
import os
import stat
from collections.abc import Iterator
from pathlib import Path

from amble.errors import InputError, WorkError
from amble.io.storage.workplace import PREFIX, workplace

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
        raise InputError(f"cannot write '{path}': it is a folder; name a file")
    if mode is not None and not stat.S_ISREG(mode):
        raise InputError(f"cannot write '{path}': it exists and is not a regular file")
    if mode is not None and not os.access(target, os.W_OK):
        raise InputError(f"cannot write '{path}': it is protected against writing")
    return target


def folder_at(path: str | Path) -> Path:
    """Return the folder that a path leads to, through links; it need not exist.

    Raises:
        InputError: where something else is in its place.
    """
    target, mode = _followed(path)
    if mode is not None and not stat.S_ISDIR(mode):
        raise InputError(f"cannot write '{path}': it is not a folder")
    return target


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
        raise kind(f"cannot write '{path}': {error.strerror or error}") from error


def _ours(path: Path, target: Path) -> bool:
    return path in (target, *target.parents) or any(part.startswith(PREFIX) for part in path.parts)


def _followed(path: str | Path) -> tuple[Path, int | None]:
    """Return the end of a chain of links and its mode; no mode where there is nothing."""
    try:
        target = Path(os.path.realpath(path))
        try:
            return target, os.stat(target).st_mode
        except FileNotFoundError:
            return target, None
    except ValueError as error:  # NUL, or a character that no file name can hold
        raise InputError(f"cannot write {os.fspath(path)!r}: no file can have this name") from error
    except OSError as error:
        raise InputError(f"cannot write '{path}': {error.strerror or error}") from error


def _probe(folder: Path, name: str) -> None:
    """Make the missing folders and the file, all inside a temporary folder."""
    present = folder
    while not present.exists():
        present = present.parent
    with workplace(present) as work:
        place = work / folder.relative_to(present)
        place.mkdir(parents=True, exist_ok=True)
        (place / name).touch()
