"""Routines of BLAS and LAPACK for code in C: their addresses, as scipy exports them."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping, Sequence
from importlib import import_module
from typing import Any


def addresses(routines: Mapping[str, Sequence[str]]) -> list[int | None]:
    """Return the addresses of routines, in order.

    Args:
        routines: "cython_blas" or "cython_lapack" -> names, such as "dgemm".
    """
    return [
        _address(import_module(f"scipy.linalg.{module}").__pyx_capi__[name])
        for module, names in routines.items()
        for name in names
    ]


def _address(capsule: Any) -> int | None:
    """Address of a function that Cython exports."""
    name, address = ctypes.pythonapi.PyCapsule_GetName, ctypes.pythonapi.PyCapsule_GetPointer
    name.restype, name.argtypes = ctypes.c_char_p, [ctypes.py_object]
    address.restype, address.argtypes = ctypes.c_void_p, [ctypes.py_object, ctypes.c_char_p]
    found = address(capsule, name(capsule))
    return None if found is None else int(found)
