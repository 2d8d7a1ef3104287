"""A folder of compiled libraries, each named by the hash of what it was made from.

A library carries the hash of its own bytes at its end, so that a damaged file is recognised before it is loaded (the
dynamic loader would crash on a truncated one). Files appear by renaming, so that writers may race: all write the
same content and the last one wins.

The hash has no key, so it is no proof of who wrote a library. What is loaded runs: folder and library must belong to
this user and be closed to the writing of others.
"""

from __future__ import annotations

import contextlib
import functools
import hashlib
import logging
import os
import stat
import tempfile
import time
from collections.abc import Callable, Iterable, Iterator
from pathlib import Path

import casadi as ca

from amble.codegen.compiler import STOP
from amble.errors import InputError
from amble.io.storage import kept_workplace, sweep, workplace

try:
    import fcntl
except ImportError:  # a system without advisory locks: two writers may then do the same work twice
    fcntl = None  # type: ignore[assignment]

logger = logging.getLogger("amble")

SEAL = b"amble-library-sha256:"

POLL = 0.05
"""Seconds between two looks at a lock that another process holds."""


def cache_folder() -> Path:
    """Folder of the compiled libraries: ``AMBLE_CACHE``, else ``amble`` in the user's cache folder.

    Raises:
        InputError: where it begins with ``~`` and there is no such home folder.
    """
    named = os.environ.get("AMBLE_CACHE")
    place = named or os.path.join(os.environ.get("XDG_CACHE_HOME") or "~/.cache", "amble")
    found = os.path.expanduser(place)
    if found.startswith("~"):
        raise InputError(f"the cache folder '{place}' has no home folder; AMBLE_CACHE can name another")
    return Path(found).absolute()


def content_key(parts: Iterable[str]) -> str:
    """Hash the parts that determine a library, in order."""
    digest = hashlib.sha256()
    for part in parts:
        data = part.encode(errors="surrogateescape")  # a path need not be UTF-8
        digest.update(f"{len(data)}:".encode())
        digest.update(data)
    return digest.hexdigest()[:40]


@functools.lru_cache(maxsize=256)
def function_key(function: ca.Function) -> str:
    """Hash a function by its serialisation, once: of a function of 70,000 instructions it takes 0.2 s."""
    return content_key([function.serialize()])


def seal(library: Path) -> None:
    """Append the hash of a library's bytes, which the loader ignores there, and close it to other users."""
    digest = hashlib.sha256(library.read_bytes()).digest()
    with library.open("ab") as stream:
        stream.write(SEAL + digest)
    library.chmod(0o700)


def intact(library: Path) -> bool:
    """Whether a library exists, is this user's alone to write, and still has the bytes that were sealed."""
    flags = os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0) | getattr(os, "O_BINARY", 0)
    try:
        with open(os.open(library, flags), "rb") as stream:
            about = os.fstat(stream.fileno())
            if not stat.S_ISREG(about.st_mode) or _foreign(about):
                return False
            data = stream.read()
    except OSError:
        return False
    body, mark, digest = data[: -len(SEAL) - 32], data[-len(SEAL) - 32 : -32], data[-32:]
    return mark == SEAL and hashlib.sha256(body).digest() == digest


def _foreign(about: os.stat_result) -> str:
    """Why another user might have written a file or folder; empty where none can."""
    if not hasattr(os, "geteuid"):  # a system that protects files otherwise
        return ""
    if about.st_uid != os.geteuid():
        return "it belongs to another user"
    return "other users may write there" if about.st_mode & (stat.S_IWGRP | stat.S_IWOTH) else ""


def kept(library: Path, build: Callable[[Path], None]) -> Path:
    """Return a library of the cache, built first where it is not there; one process at a time builds it.

    Args:
        library: ``NAME-KEY.so`` in a folder that can be written.
        build: writes the library to the path that it is given, NAME.so in a folder of its own.
    """
    name, _, key = library.stem.rpartition("-")
    if intact(library):
        return library
    with locked(library.parent, key):
        if not intact(library):  # else another process was faster
            with workplace(library.parent) as work:
                output = work / f"{name}.so"
                build(output)
                seal(output)
                os.replace(output, library)
    return library


def writable_folder() -> Path:
    """Return the cache folder, or a temporary one for this process where that cannot be written or trusted."""
    folder = cache_folder()
    try:
        _make(folder)
        reason = _untrusted(folder)
        if reason:
            return fallback_folder(f"{folder}: {reason}")
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        return fallback_folder(f"{folder}: {error.strerror or error}")
    _swept(folder)
    return folder


def _make(folder: Path) -> None:
    """Make a folder, and those above it that are missing, closed to other users."""
    if not folder.is_dir():
        missing = [place for place in (folder, *folder.parents) if not place.exists()]
        for place in reversed(missing):
            place.mkdir(mode=0o700, exist_ok=True)
        folder.mkdir(exist_ok=True)  # says what is in the way


def _untrusted(folder: Path) -> str:
    """Why another user might put a library there; empty where none can."""
    real = Path(os.path.realpath(folder))
    for place in real.parents:
        mode = place.stat().st_mode
        if hasattr(os, "geteuid") and mode & stat.S_IWOTH and not mode & stat.S_ISVTX:
            return f"every user may rename what is in {place}"
    return _foreign(real.stat())


@functools.cache
def _swept(folder: Path) -> None:
    """Remove once what killed processes left."""
    sweep(folder)


@functools.cache
def fallback_folder(reason: str) -> Path:
    """Make a temporary folder that lives as long as this process, and say why it is needed."""
    folder = kept_workplace(Path(tempfile.gettempdir()))
    logger.warning("the compile cache cannot be used (%s); using a temporary folder for this run", reason)
    return folder


@contextlib.contextmanager
def locked(folder: Path, key: str) -> Iterator[None]:
    """Let one process at a time build a key; others wait for it, and go on without waiting where locks do not work.

    Raises:
        OSError: where the lock cannot be opened, such as a link in its place.
        KeyboardInterrupt: where the work is being ended.
    """
    if fcntl is None:
        yield
        return
    lock = os.open(folder / f"{key}.lock", os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o600)
    try:
        _wait_for(lock)
        yield
    finally:
        os.close(lock)


def _wait_for(lock: int) -> None:
    """Take a lock, looking now and then whether the work is to end."""
    while not STOP.is_set():
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            time.sleep(POLL)
        except OSError:
            return
        else:
            return
    raise KeyboardInterrupt
