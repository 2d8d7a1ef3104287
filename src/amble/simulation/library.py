"""The C files of this package as loaded libraries.

The C code evaluates any casadi function, compiled or interpreted (``casadi_c.py``), so it is compiled once and for all
systems.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any

from amble.codegen.c_file import built
from amble.simulation.casadi_c import interface
from amble.types import NodeValues

FLAGS = ("-O2", "-std=c99", "-fPIC", "-shared")

DOUBLES = ctypes.POINTER(ctypes.c_double)


def doubles(array: NodeValues) -> Any:
    """Pointer to the memory of an array, which must outlive it."""
    return array.ctypes.data_as(DOUBLES)


def load(name: str) -> ctypes.PyDLL | None:
    """Load a C file of this package, compiled once for all processes.

    Args:
        name: of the file, without its ending.

    Returns:
        The library; None where there is no compiler, no place to store it, or no way to call casadi from C.
    """
    if interface() is None:
        return None
    try:
        path = built(*_files(name))
        return None if path is None else _load(path)
    except OSError:  # a full disk or a folder that may not hold libraries: Python does the work
        return None


@functools.cache
def _files(name: str) -> tuple[Path, tuple[str, ...], tuple[Path, ...]]:
    """What a library is built from; asked for at every call of one."""
    source = Path(__file__).with_name(f"{name}.c")
    return source, FLAGS, (source.with_name("callee.h"),)


@functools.cache
def _load(path: Path) -> ctypes.PyDLL:
    return ctypes.PyDLL(str(path))  # holds the global lock, as casadi's C interface needs
