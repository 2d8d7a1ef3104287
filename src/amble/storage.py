"""Safe writing of files: an interrupted command leaves the last good file, never half of one."""

from __future__ import annotations

import contextlib
import errno
import os
import secrets
from collections.abc import Iterator
from pathlib import Path

from amble.errors import InputError, WorkError

USER_ERRORS = (errno.EACCES, errno.EPERM, errno.ENOTDIR, errno.EISDIR, errno.EROFS, errno.EEXIST, errno.ENAMETOOLONG)


@contextlib.contextmanager
def replacing(path: str | Path) -> Iterator[Path]:
    """Yield a temporary path beside ``path`` that takes its place when the block ends without an exception.

    The temporary name has the same suffix, so that writers that look at it (figures, netCDF) work unchanged. Missing
    folders are made.

    Raises:
        InputError: where the place cannot be written (a file in the way, no permission).
        WorkError: where writing fails for another reason, such as a full disk.
    """
    target = Path(path)
    temporary = target.with_name(f".{target.stem}-{secrets.token_hex(4)}{target.suffix}")
    try:
        target.parent.mkdir(parents=True, exist_ok=True)
        yield temporary
        os.replace(temporary, target)
    except OSError as error:
        # an error of another file, such as one that the block reads, is not ours to reword
        if error.filename is not None and Path(os.fsdecode(error.filename)) not in (temporary, *target.parents):
            raise
        kind = InputError if error.errno in USER_ERRORS else WorkError
        raise kind(f"cannot write '{target}': {error.strerror or error}") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink()


def atomic_write(path: str | Path, content: str | bytes) -> Path:
    """Write a whole file in one step and return its path; text as UTF-8. Errors as in ``replacing``."""
    data = content.encode() if isinstance(content, str) else content
    with replacing(path) as temporary:
        temporary.write_bytes(data)
    return Path(path)
