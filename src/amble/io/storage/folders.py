"""Folders that are replaced as a whole, so that files of two versions never lie side by side."""

from __future__ import annotations

import contextlib
import os
import stat
import sys
from collections.abc import Callable, Iterator
from pathlib import Path

from amble.errors import InputError
from amble.io.storage.places import check_folder, folder_at, worded
from amble.io.storage.workplace import workplace

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2


@contextlib.contextmanager
def replacing_folder(path: str | Path, belongs: Callable[[str], bool]) -> Iterator[Path]:
    """Yield an empty folder that takes the place of ``path`` when the block ends without an exception.

    Where the system can exchange two folders in one step (Linux), another process sees the old or the new one at every
    instant; elsewhere there is none for a moment. A symbolic link stays, an existing folder keeps its permissions.

    Args:
        path: the folder; missing ones above it are made.
        belongs: whether a file of this name is one that an earlier folder of this kind had. Anything else in an
            existing folder is somebody's work: the folder is then refused.

    Raises:
        InputError: where the place cannot be written, or the existing folder may not be replaced.
        WorkError: where writing fails for another reason, such as a full disk.
    """
    check_replaceable(path, belongs)
    target = folder_at(path)
    with worded(path, target):
        target.parent.mkdir(parents=True, exist_ok=True)
        with workplace(target.parent) as work:
            fresh = work / "new"
            fresh.mkdir()
            yield fresh
            if target.exists():
                _check_content(path, target, belongs)  # it may have changed meanwhile
                fresh.chmod(stat.S_IMODE(target.stat().st_mode))
                exchange(fresh, target, work / "old")
            else:
                fresh.rename(target)


def check_replaceable(path: str | Path, belongs: Callable[[str], bool]) -> None:
    """Refuse a folder that ``replacing_folder`` would refuse, before the work whose result it is to hold."""
    target = folder_at(path)
    with worded(path, target):
        if target.is_mount():
            raise InputError(f"cannot write '{path}': a folder is replaced as a whole; name one inside it")
        if target.exists():
            _check_content(path, target, belongs)
    check_folder(target.parent)


def _check_content(path: str | Path, target: Path, belongs: Callable[[str], bool]) -> None:
    if target == Path(os.path.realpath(os.curdir)):
        raise InputError(f"cannot write '{path}': it is the current folder, which cannot be replaced; name another")
    with os.scandir(target) as entries:
        foreign = sorted(e.name for e in entries if not (e.is_file(follow_symlinks=False) and belongs(e.name)))
    if foreign:
        raise InputError(
            f"cannot write '{path}': the folder would be replaced as a whole, and '{foreign[0]}' in it was not "
            "written by this command; move it or name another folder"
        )


def exchange(new: Path, target: Path, aside: Path) -> None:
    """Exchange two folders of one file system in one step; in two, over ``aside``, where that does not exist."""
    if sys.platform == "linux":
        import ctypes

        swap = getattr(ctypes.CDLL(None, use_errno=True), "renameat2", None)
        if swap is not None and swap(_AT_FDCWD, bytes(new), _AT_FDCWD, bytes(target), _RENAME_EXCHANGE) == 0:
            return
    target.rename(aside)
    try:
        new.rename(target)
    except OSError:
        aside.rename(target)
        raise
