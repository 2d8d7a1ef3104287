"""One thread for the small dense blocks inside the sparse solver: more only wait for each other."""

from __future__ import annotations

import contextlib
import ctypes
import os
from collections.abc import Iterator

import casadi as ca

LOADED = "libcasadi-tp-openblas.so.0"
"""Name of the library in casadi's wheels for Linux."""


@contextlib.contextmanager
def single_threaded() -> Iterator[None]:
    """Let the OpenBLAS that casadi ships with use one thread inside the block, and as many as before afterwards.

    Measured on the amble with 15 intervals and two busy cores: 0.36 s of processor time an iteration with two threads,
    0.10 s with one. Where casadi was built with another BLAS nothing changes.
    """
    library = _library()
    if library is None:
        yield
        return
    before = int(library.openblas_get_num_threads())
    library.openblas_set_num_threads(1)
    try:
        yield
    finally:
        library.openblas_set_num_threads(before)


def _library() -> ctypes.CDLL | None:
    """Find the OpenBLAS that IPOPT has loaded; by its name alone, for a file's path might load a second copy."""
    ca.has_nlpsol("ipopt")  # loads it as well
    try:
        library = ctypes.CDLL(LOADED, mode=getattr(os, "RTLD_NOLOAD", 0) | getattr(os, "RTLD_NOW", 0))
    except OSError:
        return None
    return library if hasattr(library, "openblas_set_num_threads") else None
