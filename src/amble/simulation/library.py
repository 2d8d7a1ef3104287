"""The C files of this package as loaded libraries, and casadi's entry for callers in C.

The C code evaluates any casadi function, compiled or interpreted, through casadi's own buffer interface
(``Function.buffer``), so it is compiled once and for all systems.
"""

from __future__ import annotations

import ctypes
import functools
from pathlib import Path
from typing import Any

import casadi as ca

from amble.codegen.cache import content_key, kept, writable_folder
from amble.codegen.compiler import Compiler, compiler
from amble.types import NodeValues

FLAGS = ("-O2", "-std=c99", "-fPIC", "-shared")
EVALUATE = "_ZN6casadi21_function_buffer_evalEPv"
"""casadi::_function_buffer_eval(void*), which casadi exports for callers in C."""

DOUBLES = ctypes.POINTER(ctypes.c_double)


def doubles(array: NodeValues) -> Any:
    """Pointer to the memory of an array, which must outlive it."""
    return array.ctypes.data_as(DOUBLES)


def address(buffer: ca.FunctionBuffer) -> int:
    """Return the pointer inside the capsule that casadi hands out."""
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
    return int(pointer(buffer._self(), None))


@functools.cache
def evaluation() -> int | None:
    """Address of casadi's evaluation of a buffer; None on a platform that names it otherwise."""
    function = getattr(ctypes.CDLL(ca._casadi.__file__), EVALUATE, None)
    return None if function is None else ctypes.cast(function, ctypes.c_void_p).value


def load(name: str) -> ctypes.CDLL | None:
    """Load a C file of this package, compiled once for all processes.

    Args:
        name: of the file, without its ending.

    Returns:
        The library; None where there is no compiler, no place to store it, or no way to call casadi from C.
    """
    tool = compiler()
    if tool is None or evaluation() is None:
        return None
    try:
        return _load(_built(name, tool))
    except OSError:  # a full disk or a folder that may not hold libraries: Python does the work
        return None


@functools.cache
def _load(path: Path) -> ctypes.CDLL:
    return ctypes.CDLL(str(path))


@functools.cache
def _built(name: str, tool: Compiler) -> Path:
    source = Path(__file__).with_name(f"{name}.c")
    folder = writable_folder()
    texts = [source.read_text(), source.with_name("callee.h").read_text()]
    key = content_key([*texts, tool.path, tool.version, *FLAGS])
    return kept(folder / f"{name}-{key}.so", lambda output: tool.build(source, output, FLAGS))
