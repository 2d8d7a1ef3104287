"""Files, and folders as a whole, that appear complete or not at all."""

from __future__ import annotations

import contextlib
import json
import os
import stat
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from amble.errors import InputError, shown, shown_path
from amble.io.storage.places import check_folder, file_at, folder_at, worded, workplace

_AT_FDCWD, _RENAME_EXCHANGE = -100, 2


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path that takes the place of ``path`` when the block ends without an exception.

    The temporary file has the same name, so that writers that look at it (figures, netCDF) work unchanged. Missing
    folders are made. A symbolic link stays and the file that it leads to is replaced; an existing file keeps its
    permissions and, where that is allowed, its owner.

    Raises:
        InputError: where the place cannot be written (a file in the way, no permission).
        WorkError: where writing fails for another reason, such as a full disk.
    """
    target = file_at(path)
    with worded(path, target):
        target.parent.mkdir(parents=True, exist_ok=True)
        with workplace(target.parent) as work:
            temporary = work / Path(path).name
            yield temporary
            _keep_permissions(target, temporary)
            os.replace(temporary, target)


def atomic_write(path: str | Path, content: str | bytes) -> Path:
    """Write a whole file in one step and return its path; text as UTF-8. Errors as in ``replacing``."""
    try:
        data = content.encode() if isinstance(content, str) else content
    except UnicodeEncodeError as error:
        character = error.object[error.start]
        raise InputError(
            f"cannot write '{shown_path(path)}': the text holds {character!a}, which is no character"
        ) from error
    with replacing(path) as temporary:
        temporary.write_bytes(data)
    return Path(path)


def dumps(tree: Any, indent: str = "") -> str:
    """JSON text with one line for every list of plain values, so that a matrix reads as one."""
    deeper = indent + "  "
    if isinstance(tree, dict) and tree and any(isinstance(value, dict | list) for value in tree.values()):
        body = ",\n".join(f"{deeper}{json.dumps(key)}: {dumps(value, deeper)}" for key, value in tree.items())
        return f"{{\n{body}\n{indent}}}"
    if isinstance(tree, list) and any(isinstance(value, dict | list) for value in tree):
        body = ",\n".join(f"{deeper}{dumps(value, deeper)}" for value in tree)
        return f"[\n{body}\n{indent}]"
    return json.dumps(tree, allow_nan=False, ensure_ascii=False)


def _keep_permissions(target: Path, temporary: Path) -> None:
    """Give the new file what the old one had."""
    try:
        old = target.stat()
    except FileNotFoundError:
        return
    new = temporary.stat()
    if hasattr(os, "chown") and (old.st_uid, old.st_gid) != (new.st_uid, new.st_gid):
        with contextlib.suppress(PermissionError):
            os.chown(temporary, old.st_uid, old.st_gid)
    temporary.chmod(stat.S_IMODE(old.st_mode) & 0o777)


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
            raise InputError(f"cannot write '{shown_path(path)}': a folder is replaced as a whole; name one inside it")
        if target.exists():
            _check_content(path, target, belongs)
    check_folder(target.parent)


def _check_content(path: str | Path, target: Path, belongs: Callable[[str], bool]) -> None:
    if target == Path(os.path.realpath(os.curdir)):
        raise InputError(
            f"cannot write '{shown_path(path)}': it is the current folder, which cannot be replaced; name another"
        )
    with os.scandir(target) as entries:
        foreign = sorted(e.name for e in entries if not (e.is_file(follow_symlinks=False) and belongs(e.name)))
    if foreign:
        raise InputError(
            f"cannot write '{shown_path(path)}': the folder would be replaced as a whole, and "
            f"'{shown(foreign[0])}' in it was not written by this command; move it or name another folder"
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
