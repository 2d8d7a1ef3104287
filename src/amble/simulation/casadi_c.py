"""Casadi functions for callers in C, through casadi's public C interface (its header ``casadi_c.h``).

The interface holds functions in one list for the whole process, numbered in the order of loading, and is not safe among
threads: everything here, and the C code that evaluates, runs while Python's global lock is held (``ctypes.PyDLL``).
"""

from __future__ import annotations

import ctypes
import functools
import importlib.util
import tempfile
import weakref
from dataclasses import dataclass
from pathlib import Path

import casadi as ca

from amble.codegen.cache import function_key

RECENT = 64
"""Functions that are kept for whoever asks for them again; handing one over takes a millisecond."""

_INTEGER = ctypes.c_longlong
_SIZES = ctypes.POINTER(_INTEGER)


@functools.cache
def interface() -> ctypes.PyDLL | None:
    """Casadi's C interface; None on a platform that does not export it or has integers of another width."""
    extension = importlib.util.find_spec("casadi._casadi")
    if extension is None or extension.origin is None:
        return None
    library = ctypes.PyDLL(extension.origin)  # a symbol is looked for in the libraries that it is linked to as well
    try:
        library.casadi_c_push_file.argtypes = (ctypes.c_char_p,)
        library.casadi_c_work_id.argtypes = (ctypes.c_int, _SIZES, _SIZES, _SIZES, _SIZES)
        for name in ("eval_id", "checkout_id", "release_id", "pop", "n_loaded"):
            getattr(library, f"casadi_c_{name}")
        fits = library.casadi_c_int_width() == ctypes.sizeof(_INTEGER) and library.casadi_c_real_width() == 8
    except AttributeError:
        return None
    return library if fits else None


@dataclass(frozen=True, eq=False)
class Held:
    """A function that the interface holds for as long as this object lives, by its number in the list."""

    number: int


@dataclass(frozen=True, eq=False, kw_only=True)
class Loaded:
    """What an evaluation takes: a function and memory of its own.

    Attributes:
        held: the function.
        memory: number of the memory object of casadi.
        arguments, results: pointers to arrays, null to begin with.
        integers, reals: work space.
    """

    held: Held
    memory: int
    arguments: ctypes.Array[ctypes.c_void_p]
    results: ctypes.Array[ctypes.c_void_p]
    integers: ctypes.Array[ctypes.c_longlong]
    reals: ctypes.Array[ctypes.c_double]


_recent: dict[str, Held] = {}
_free: set[int] = set()
"""Numbers of functions that nobody uses any more, while functions that were loaded later are in use."""


def loaded(function: ca.Function) -> Loaded | None:
    """Hand a function to the interface; None where there is none, or where the function cannot be handed over."""
    library = interface()
    held = None if library is None else _held(function, library)
    if library is None or held is None:
        return None
    sizes = [_INTEGER() for _ in range(4)]
    library.casadi_c_work_id(held.number, *map(ctypes.byref, sizes))
    n_arguments, n_results, n_integers, n_reals = (size.value for size in sizes)
    found = Loaded(
        held=held,
        memory=int(library.casadi_c_checkout_id(held.number)),
        arguments=(ctypes.c_void_p * n_arguments)(),
        results=(ctypes.c_void_p * n_results)(),
        integers=(_INTEGER * n_integers)(),
        reals=(ctypes.c_double * n_reals)(),
    )
    # holds the function: it goes after its memory
    weakref.finalize(found, _release, held, found.memory, library).atexit = False
    return found


def _held(function: ca.Function, library: ctypes.PyDLL) -> Held | None:
    """Return the number of a function, which goes through a temporary file, the only way that the interface has."""
    key = function_key(function)
    if key in _recent:
        return _recent[key]
    if len(_recent) >= RECENT:  # all at once: the interface takes functions from the end of its list only
        _recent.clear()
    try:
        with tempfile.TemporaryDirectory(prefix="amble-") as folder:
            file = Path(folder, "function.casadi")
            function.save(str(file))
            if library.casadi_c_push_file(bytes(file)) != 0:
                return None
    except (OSError, RuntimeError):  # no place for the file: Python does the work
        return None
    held = Held(library.casadi_c_n_loaded() - 1)
    _free.discard(held.number)
    weakref.finalize(held, _give_back, held.number, library).atexit = False
    _recent[key] = held
    return held


def _release(held: Held, memory: int, library: ctypes.PyDLL) -> None:
    library.casadi_c_release_id(held.number, memory)


def _give_back(number: int, library: ctypes.PyDLL) -> None:
    """Take unused functions from the end of the interface's list."""
    _free.add(number)
    while (last := library.casadi_c_n_loaded() - 1) in _free:
        library.casadi_c_pop()
        if library.casadi_c_n_loaded() == last:  # else it took the empty place of a file that could not be loaded
            _free.discard(last)
