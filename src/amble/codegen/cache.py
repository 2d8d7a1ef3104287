"""A folder of compiled libraries, each named by the hash of what it was made from.

A library carries the hash of its own bytes at its end, so that a damaged file is recognised before it is loaded (the
dynamic loader would crash on a truncated one). Files appear by renaming, so that writers may race: all write the
same content and the last one wins.
"""

from __future__ import annotations

import atexit
import contextlib
import functools
import hashlib
import logging
import os
import shutil
import tempfile
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

logger = logging.getLogger("amble")

SEAL = b"amble-library-sha256:"


def cache_folder() -> Path:
    """Folder of the compiled libraries: ``AMBLE_CACHE``, else ``amble`` in the user's cache folder."""
    named = os.environ.get("AMBLE_CACHE")
    if named:
        return Path(named).expanduser().absolute()
    return Path(os.environ.get("XDG_CACHE_HOME") or "~/.cache").expanduser().absolute() / "amble"


def content_key(parts: Iterable[str]) -> str:
    """Hash the parts that determine a library, in order."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode()
        digest.update(f"{len(data)}:".encode())
        digest.update(data)
    return digest.hexdigest()[:40]


def seal(library: Path) -> None:
    """Append the hash of a library's bytes to it; the loader ignores what follows the last section."""
    digest = hashlib.sha256(library.read_bytes()).digest()
    with library.open("ab") as stream:
        stream.write(SEAL + digest)


def intact(library: Path) -> bool:
    """Whether a library exists and still has the bytes that were sealed."""
    try:
        data = library.read_bytes()
    except OSError:
        return False
    body, mark, digest = data[: -len(SEAL) - 32], data[-len(SEAL) - 32 : -32], data[-32:]
    return mark == SEAL and hashlib.sha256(body).digest() == digest


def kept(library: Path, build: Callable[[Path], None]) -> Path:
    """Return a library of the cache, built first where it is not there; one process at a time builds it.

    Args:
        library: ``NAME-KEY.so`` in a folder that can be written.
        build: writes the library to the path that it is given, NAME.so in a folder of its own.
    """
    name, _, key = library.stem.rpartition("-")
    if intact(library):
        return library
    with locked(library.parent, key), tempfile.TemporaryDirectory(dir=library.parent, prefix="build-") as work:
        if not intact(library):  # else another process was faster
            output = Path(work, f"{name}.so")
            build(output)
            seal(output)
            os.replace(output, library)
    return library


def writable_folder() -> Path:
    """Return the cache folder, or a temporary one for this process where that cannot be written."""
    folder = cache_folder()
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return fallback_folder(f"{folder}: {error.strerror or error}")
    return folder


@functools.cache
def fallback_folder(reason: str) -> Path:
    """Make a temporary folder that lives as long as this process, and say why it is needed."""
    folder = Path(tempfile.mkdtemp(prefix="amble-"))
    atexit.register(shutil.rmtree, folder, ignore_errors=True)
    logger.warning("the compile cache cannot be written (%s); using a temporary folder for this run", reason)
    return folder


@contextlib.contextmanager
def locked(folder: Path, key: str) -> Iterator[None]:
    """Let one process at a time build a key; others wait for it, and go on without waiting where locks do not work."""
    import fcntl  # POSIX has it; on another system the search for a compiler has said so before

    with (folder / f"{key}.lock").open("w") as stream:
        with contextlib.suppress(OSError):
            fcntl.flock(stream, fcntl.LOCK_EX)
        yield
