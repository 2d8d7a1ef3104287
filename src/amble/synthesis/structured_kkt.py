"""The structured KKT solver as a library that IPOPT takes for MA27: compiled once, on the BLAS that is there."""

from __future__ import annotations

import contextlib
import ctypes
import functools
import logging
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from amble.codegen.c_file import built
from amble.errors import printable
from amble.numerics.blas import addresses
from amble.synthesis.elimination import NotSquareError
from amble.synthesis.kkt_plan import build_plan
from amble.synthesis.kkt_structures import KeptPlan, Plan
from amble.synthesis.program import GaitProgram
from amble.synthesis.watch import loaded_blas

logger = logging.getLogger("amble")

SOURCE = Path(__file__).with_name("structured_kkt.c")
FLAGS = ("-O3", "-std=gnu99", "-fPIC", "-shared")
"""Without -ffast-math: signs of pivots and checks for what is no number have to hold."""

ROUTINES = {
    "cython_blas": ("dgemm", "dgemv", "dsymm", "dsyrk", "dsyr2k"),
    "cython_lapack": ("dgetrf", "dgetrs", "dsytrf", "dsytrs"),
}
"""What the C code calls, in its order, by scipy's modules."""

REASONS = {
    1: "the KKT system has another structure than the program",
    2: "IPOPT regularises the equality rows",
    3: "a node or an interval has dependent rows",
    4: "a residual is too large",
    5: "memory is short",
}
"""Why the C code refuses a system."""

OPTIONS: dict[str, Any] = {
    "linear_solver": "ma27",
    "linear_system_scaling": "none",
    "ma27_pivtol": 1e-8,
    "ma27_pivtolmax": 1e-8,  # there is no tighter pivot to ask for
    "min_refinement_steps": 0,  # it refines by itself where a residual asks for it
    "fixed_variable_treatment": "make_constraint",  # so that every unknown of a node is one of IPOPT's
}
"""Options of IPOPT, beside the library's path."""


class UnavailableError(Exception):
    """The structured solver cannot be used; the message says why."""


class _Blas(ctypes.Structure):
    """``Blas`` of structured_kkt.c."""

    _fields_ = [(name, ctypes.c_void_p) for names in ROUTINES.values() for name in names]


@dataclass(frozen=True, kw_only=True)
class StructuredKkt:
    """A structured solver for the KKT systems of one program.

    Attributes:
        path: the library, for IPOPT's option ``hsllib``.
        library: the same, loaded.
        handle: the C code's solver.
        plan: what the handle points to.
    """

    path: Path
    library: ctypes.CDLL
    handle: int
    plan: KeptPlan

    @property
    def options(self) -> dict[str, Any]:
        """IPOPT's options with which it uses this solver."""
        return {**OPTIONS, "hsllib": str(self.path)}

    @property
    def refusal(self) -> str:
        """Why it refused a system, or was never asked; empty where it solved all."""
        reason, counts, _ = self._report()
        return REASONS[reason] if reason else "" if counts[1] else "IPOPT does not use the library"

    @property
    def counts(self) -> tuple[int, int, int]:
        """Factorisations, solutions, refinements."""
        return self._report()[1]

    @property
    def worst_residual(self) -> float:
        """Largest residual of a solution over the largest entry of |K| |x| + |b|."""
        return self._report()[2]

    def _report(self) -> tuple[int, tuple[int, int, int], float]:
        counts, worst = (ctypes.c_long * 3)(), ctypes.c_double()
        reason = self.library.amble_kkt_report(self.handle, counts, ctypes.byref(worst))
        return int(reason), (counts[0], counts[1], counts[2]), worst.value


@contextlib.contextmanager
def structured_kkt(program: GaitProgram) -> Iterator[StructuredKkt]:
    """Make the structured solver of a program that of this thread inside the block.

    Raises:
        UnavailableError: there is no compiler, no BLAS, or rows and unknowns do not pair.
    """
    library, path, blas = _library()
    try:
        plan = build_plan(program)
    except NotSquareError as error:
        logger.info("%s", printable(str(error)))
        raise UnavailableError("rows and unknowns of a node or an interval do not pair") from None
    handle = library.amble_kkt_new(ctypes.byref(plan.plan), ctypes.byref(blas))
    if not handle:
        raise UnavailableError(REASONS[5])
    before = library.amble_kkt_use(handle)
    try:
        yield StructuredKkt(path=path, library=library, handle=handle, plan=plan)
    finally:
        library.amble_kkt_use(before)
        library.amble_kkt_free(handle)


def _library() -> tuple[ctypes.CDLL, Path, _Blas]:
    try:
        path = built(SOURCE, FLAGS)
    except OSError as error:
        raise UnavailableError(f"compiled code cannot be stored ({error.strerror or error})") from None
    if path is None:
        raise UnavailableError("no C compiler found")
    return _loaded(path), path, _blas()


@functools.cache
def _loaded(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    library.amble_kkt_new.argtypes = [ctypes.POINTER(Plan), ctypes.POINTER(_Blas)]
    library.amble_kkt_new.restype = library.amble_kkt_use.restype = ctypes.c_void_p
    library.amble_kkt_use.argtypes = library.amble_kkt_free.argtypes = [ctypes.c_void_p]
    library.amble_kkt_report.argtypes = [
        ctypes.c_void_p,
        ctypes.POINTER(ctypes.c_long),
        ctypes.POINTER(ctypes.c_double),
    ]
    return library


@functools.cache
def _blas() -> _Blas:
    """The BLAS that IPOPT has loaded, which is kept to one thread; else scipy's."""
    names = [name for group in ROUTINES.values() for name in group]
    library = loaded_blas()
    if library is not None and all(hasattr(library, f"{name}_") for name in names):
        return _Blas(*[ctypes.cast(getattr(library, f"{name}_"), ctypes.c_void_p).value for name in names])
    return _Blas(*addresses(ROUTINES))
