"""The C compiler: found once, told apart by its version, run in a subprocess.

``AMBLE_COMPILER`` overrides the search: a program name or path, or ``none`` for no compiler at all.
"""

from __future__ import annotations

import errno
import functools
import logging
import os
import shutil
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from amble.errors import InputError, WorkError

POSIX = os.name == "posix"
"""Whether this system has what compiled code, locks and signals rest on."""
logger = logging.getLogger("amble")

CANDIDATES = ("cc", "gcc", "clang")
FLAGS = ("-Og", "-fPIC", "-shared", "-pipe")
"""-Og because the register allocation of higher levels takes minutes on node functions (docs/decisions.md)."""

STDERR_TAIL = 2000

VERSION_LIMIT = 10.0
"""Seconds that a compiler may take to tell its version."""

BUILD_LIMIT, BUILD_LIMIT_PER_BYTE = 120.0, 3e-4
"""Seconds that a build may take, and those for every byte of C: thirty times what gcc took on a busy machine."""

POLL = 0.1
"""Seconds between two looks at whether the work is to end."""

STOP = threading.Event()
"""Set while the work of other threads is being ended: compilers are stopped, and whoever waits for a lock gives up."""

TRIAL = "import ctypes, sys; library = ctypes.CDLL(sys.argv[1]); [getattr(library, name) for name in sys.argv[2:]]"


@dataclass(frozen=True)
class Compiler:
    """A C compiler: absolute path and the first line of its version."""

    path: str
    version: str

    def build(self, source: Path, library: Path, flags: Sequence[str] = FLAGS, names: Sequence[str] = ()) -> None:
        """Compile one C file to a shared library and try whether it loads.

        Args:
            source: the C file.
            library: where to write.
            flags: of the compiler, and further C files.
            names: of functions that the library must have.

        Raises:
            OSError: where the disk is full or its libraries cannot be run.
            WorkError: where the compiler fails for another reason, takes too long, or writes what is no such library.
        """
        command = [self.path, *flags, "-o", str(library), str(source), "-lm"]
        # what a killed compiler leaves is swept with the folder of the library
        environment = {**os.environ, "LC_ALL": "C", "TMPDIR": str(library.parent)}
        size = sum(os.path.getsize(each) for each in command if each.endswith(".c"))
        limit = BUILD_LIMIT + BUILD_LIMIT_PER_BYTE * size
        try:
            code, _, messages = _run(command, limit, environment)
        except subprocess.TimeoutExpired:
            raise WorkError(f"{self.path} was stopped: it took more than {limit:.0f} s on {source.name}") from None
        except OSError as error:
            raise WorkError(f"{self.path} does not run: {error.strerror or error}") from error
        if code == 0:
            self._try(library, names)
            return
        if os.strerror(errno.ENOSPC) in messages:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(library))
        raise WorkError(f"{self.path} failed on {source.name} (exit {code}):\n{messages[-STDERR_TAIL:]}")

    def _try(self, library: Path, names: Sequence[str]) -> None:
        """Load a library in another process: the dynamic loader may crash on a damaged one."""
        try:
            code, _, messages = _run([sys.executable, "-I", "-S", "-c", TRIAL, str(library), *names], VERSION_LIMIT)
        except subprocess.TimeoutExpired:
            code, messages = 1, "loading it takes too long"
        if code == 0:
            return
        if "failed to map segment" in messages:
            raise OSError(errno.EPERM, "libraries in this folder may not be run", str(library))
        reason = (messages.splitlines() or [f"loading it ends with {code}"])[-1]
        raise WorkError(f"{self.path} reports success, but '{library.name}' cannot be used: {reason}")


def _run(command: Sequence[str], limit: float, environment: dict[str, str] | None = None) -> tuple[int, str, str]:
    """Run a program in a session of its own, which ends with it, and return its exit code and what it said.

    Raises:
        OSError: where it cannot be started.
        subprocess.TimeoutExpired: where it takes more than ``limit`` seconds.
        KeyboardInterrupt: where the work is being ended.
    """
    pipe = subprocess.PIPE
    end = time.monotonic() + limit
    with subprocess.Popen(
        command, stdin=subprocess.DEVNULL, stdout=pipe, stderr=pipe, env=environment, start_new_session=True
    ) as process:
        try:
            while True:
                try:
                    output, messages = process.communicate(timeout=POLL)
                    return process.returncode, output.decode(errors="replace"), messages.decode(errors="replace")
                except subprocess.TimeoutExpired:
                    if STOP.is_set():
                        raise KeyboardInterrupt from None
                    if time.monotonic() > end:
                        raise
        except BaseException:
            _kill(process)
            raise


def _kill(process: subprocess.Popen[bytes]) -> None:
    """End a program and what it started; a compiler is a driver of others, which would hold its pipes open."""
    if hasattr(os, "killpg"):
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            return
    else:
        process.kill()


def compiler() -> Compiler | None:
    """Find the C compiler; None where there is none or ``AMBLE_COMPILER=none``.

    Raises:
        InputError: where ``AMBLE_COMPILER`` names a program that does not exist or does not run.
        WorkError: on a system that is not POSIX; everything that computes asks here first.
    """
    if not POSIX:
        raise WorkError("amble runs on POSIX systems only (Linux, macOS, Windows' subsystem for Linux)")
    wanted = os.environ.get("AMBLE_COMPILER", "")
    if wanted == "none":
        return None
    if wanted:
        path = shutil.which(wanted)
        found = _identify(path) if path else None
        if not isinstance(found, Compiler):
            raise InputError(f"AMBLE_COMPILER names '{wanted}', which {found or 'is not a program that runs'}")
        return found
    return _first(os.environ.get("PATH"))


@functools.cache
def _first(_: str | None) -> Compiler | None:
    """Return the first candidate on the path, as which the environment has it; looked up a thousand times."""
    for candidate in CANDIDATES:
        path = shutil.which(candidate)
        found = _identify(path) if path else None
        if isinstance(found, Compiler):
            return found
    return None


@functools.cache
def _identify(path: str) -> Compiler | str:
    """Return the compiler at a path, or what is wrong with it."""
    try:
        code, output, _ = _run([path, "--version"], VERSION_LIMIT)
    except subprocess.TimeoutExpired:
        logger.warning("%s does not tell its version within %g s and is not used", path, VERSION_LIMIT)
        return f"does not tell its version within {VERSION_LIMIT:g} s"
    except OSError:
        return "is not a program that runs"
    return Compiler(path, (output.splitlines() or [""])[0]) if code == 0 else "is not a program that runs"
