"""The C compiler: found once, told apart by its version, run in a subprocess.

``AMBLE_COMPILER`` overrides the search: a program name or path, or ``none`` for no compiler at all.
"""

from __future__ import annotations

import errno
import functools
import os
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from amble.errors import InputError, WorkError

POSIX = os.name == "posix"
"""Whether this system has what compiled code, locks and signals rest on."""

CANDIDATES = ("cc", "gcc", "clang")
FLAGS = ("-O1", "-fPIC", "-shared", "-pipe")
"""-O1 because the register allocation of higher levels takes minutes on node functions (docs/decisions.md)."""

STDERR_TAIL = 2000


@dataclass(frozen=True)
class Compiler:
    """A C compiler: absolute path and the first line of its version."""

    path: str
    version: str

    def build(self, source: Path, library: Path, flags: Sequence[str] = FLAGS) -> None:
        """Compile one C file to a shared library.

        Raises:
            OSError: where the disk is full.
            WorkError: where the compiler fails for another reason; the end of its messages is in the error.
        """
        command = [self.path, *flags, "-o", str(library), str(source), "-lm"]
        environment = {**os.environ, "LC_ALL": "C"}
        done = subprocess.run(command, capture_output=True, text=True, check=False, env=environment)
        if done.returncode == 0:
            return
        if os.strerror(errno.ENOSPC) in done.stderr:
            raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC), str(library))
        raise WorkError(f"{self.path} failed on {source.name} (exit {done.returncode}):\n{done.stderr[-STDERR_TAIL:]}")


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
        if found is None:
            raise InputError(f"AMBLE_COMPILER names '{wanted}', which is not a program that runs")
        return found
    for candidate in CANDIDATES:
        path = shutil.which(candidate)
        found = _identify(path) if path else None
        if found is not None:
            return found
    return None


@functools.cache
def _identify(path: str) -> Compiler | None:
    try:
        done = subprocess.run([path, "--version"], capture_output=True, text=True, check=True)
    except (OSError, subprocess.CalledProcessError):
        return None
    return Compiler(path, (done.stdout.splitlines() or [""])[0])
