"""Files that appear whole or not at all."""

from __future__ import annotations

import contextlib
import json
import os
import stat
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from amble.errors import InputError
from amble.io.storage.places import file_at, worded
from amble.io.storage.workplace import workplace


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
        raise InputError(f"cannot write '{path}': the text holds {character!a}, which is no character") from error
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
