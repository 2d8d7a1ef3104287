"""The C files of this package as loaded libraries.

The C code evaluates any casadi function, compiled or interpreted (``casadi_c.py``), so it is compiled once and for all
systems.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any

from amble.codegen.cache import content_key, kept, writable_folder
from amble.codegen.compiler import Compiler, compiler
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
    tool = compiler()
    if tool is None or interface() is None:
        return None
    try:
        return _load(_built(name, tool))
    except OSError:  # a full disk or a folder that may not hold libraries: Python does the work
        return None


@functools.cache
def _load(path: Path) -> ctypes.PyDLL:
    return ctypes.PyDLL(str(path))  # holds the global lock, as casadi's C interface needs


@functools.cache
def _built(name: str, tool: Compiler) -> Path:
    source = Path(__file__).with_name(f"{name}.c")
    folder = writable_folder()
    texts = [source.read_text(), source.with_name("callee.h").read_text()]
    key = content_key([*texts, tool.path, tool.version, *FLAGS])
    return kept(folder / f"{name}-{key}.so", lambda output: tool.build(source, output, FLAGS))
