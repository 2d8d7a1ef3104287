"""The flow through a domain in native code: one call of ``dormand_prince.c`` a domain.

The C code evaluates any casadi function, compiled or interpreted, through casadi's own buffer interface
(``Function.buffer``), so it is compiled once and for all systems.
"""

from __future__ import annotations

import ctypes
import functools
import os
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np

from amble.codegen.cache import content_key, intact, locked, seal, writable_folder
from amble.codegen.compiler import Compiler, compiler
from amble.errors import WorkError
from amble.simulation.bound import Bound, bind
from amble.simulation.flow import RESOLUTION, STUCK, TOO_LONG, Course, Flow, Passage
from amble.simulation.tableau import dop853
from amble.types import NodeValues, Vector

SOURCE = Path(__file__).with_name("dormand_prince.c")
FLAGS = ("-O2", "-std=c99", "-fPIC", "-shared")
EVALUATE = "_ZN6casadi21_function_buffer_evalEPv"
"""casadi::_function_buffer_eval(void*), which casadi exports for callers in C."""

CROSSED, NO_MEMORY = 0, 3
REASONS = {1: TOO_LONG, 2: STUCK}

TABLEAU = ("a", "c", "error3", "error5", "dense")
"""The arrays of the method, in the order of the C structure."""

_DOUBLES = ctypes.POINTER(ctypes.c_double)


class _Callee(ctypes.Structure):
    _fields_ = (("handle", ctypes.c_void_p), ("clock", _DOUBLES), ("state", _DOUBLES), ("out", _DOUBLES))


class _Tableau(ctypes.Structure):
    _fields_ = tuple((name, _DOUBLES) for name in TABLEAU)


class _Problem(ctypes.Structure):
    _fields_ = (
        ("evaluate", ctypes.c_void_p),
        ("field", ctypes.POINTER(_Callee)),
        ("guards", ctypes.POINTER(_Callee)),
        ("sign", _DOUBLES),
        ("first", _DOUBLES),
        ("kinks", _DOUBLES),
        ("n", ctypes.c_int),
        ("n_guards", ctypes.c_int),
        ("n_kinks", ctypes.c_int),
    )


@dataclass(frozen=True)
class NativeFlow:
    """A prepared flow; ``kept`` holds the memory that the C structures point to."""

    course: Course
    routine: Any
    problem: _Problem
    tableau: _Tableau
    kept: tuple[Any, ...]

    def __call__(self, start: Vector, tolerance: float, longest: float, samples: int) -> Passage:
        """Integrate from a state at clock 0 until a watched function fires or the flow has lasted ``longest`` (s)."""
        entry = np.array(start, dtype=np.float64)
        clock, state = np.zeros(samples), np.tile(entry, (samples, 1))
        end, fired, steps = ctypes.c_double(), ctypes.c_int(), ctypes.c_int()
        status = self.routine(
            ctypes.byref(self.problem), ctypes.byref(self.tableau), _doubles(entry), tolerance, longest,
            samples, _doubles(clock), _doubles(state), ctypes.byref(end), ctypes.byref(fired), ctypes.byref(steps),
        )  # fmt: skip
        if status == NO_MEMORY:
            raise WorkError(f"the simulation of '{self.course.field.name()}' ran out of memory")
        if status != CROSSED:
            return Passage(clock, state, None, REASONS[status], steps.value)
        which, ended = self.course.outcome(fired.value)
        return Passage(clock, state, which, ended, steps.value)


def prepare(course: Course) -> Flow | None:
    """Prepare a flow; None where there is no C compiler or casadi's buffer interface cannot be reached from C."""
    library = _library()
    evaluate = _evaluate_address()
    if library is None or evaluate is None:
        return None
    followed = bind(course.field, course.parameters)
    watched = [bind(item.function, course.parameters) for item in course.watched]
    field, guards = _callee(followed), (_Callee * len(watched))(*map(_callee, watched))
    sign = np.array([float(item.direction) for item in course.watched])
    first = np.array([max(item.earliest, RESOLUTION) for item in course.watched])
    kinks = np.array(course.kinks)
    problem = _Problem(
        evaluate, ctypes.pointer(field), ctypes.cast(guards, ctypes.POINTER(_Callee)), _doubles(sign), _doubles(first),
        _doubles(kinks), course.field.numel_in(1), len(watched), kinks.size,
    )  # fmt: skip
    method = dop853()
    arrays = tuple(np.array(getattr(method, name)) for name in TABLEAU)
    kept = (followed, watched, field, guards, sign, first, kinks, arrays)
    return NativeFlow(course, library.amble_flow, problem, _Tableau(*map(_doubles, arrays)), kept)


def _callee(bound: Bound) -> _Callee:
    return _Callee(_address(bound.buffer), _doubles(bound.clock), _doubles(bound.state), _doubles(bound.results[0]))


def _address(buffer: ca.FunctionBuffer) -> int:
    """Return the pointer inside the capsule that casadi hands out."""
    pointer = ctypes.pythonapi.PyCapsule_GetPointer
    pointer.restype, pointer.argtypes = ctypes.c_void_p, (ctypes.py_object, ctypes.c_char_p)
    return int(pointer(buffer._self(), None))


def _doubles(array: NodeValues) -> Any:
    return array.ctypes.data_as(_DOUBLES)


@functools.cache
def _evaluate_address() -> int | None:
    """Address of casadi's evaluation of a buffer; None on a platform that names it otherwise."""
    function = getattr(ctypes.CDLL(ca._casadi.__file__), EVALUATE, None)
    return None if function is None else ctypes.cast(function, ctypes.c_void_p).value


def _library() -> ctypes.CDLL | None:
    """Compile the C file, once for all processes; None where there is no compiler or no place to store it."""
    tool = compiler()
    if tool is None:
        return None
    try:
        return _load(_built(tool))
    except OSError:  # a full disk or a folder that may not hold libraries: scipy does the work
        return None


@functools.cache
def _load(path: Path) -> ctypes.CDLL:
    library = ctypes.CDLL(str(path))
    library.amble_flow.argtypes = (
        ctypes.POINTER(_Problem), ctypes.POINTER(_Tableau), _DOUBLES, ctypes.c_double, ctypes.c_double,
        ctypes.c_int, _DOUBLES, _DOUBLES, ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_int),
        ctypes.POINTER(ctypes.c_int),
    )  # fmt: skip
    library.amble_flow.restype = ctypes.c_int
    return library


@functools.cache
def _built(tool: Compiler) -> Path:
    folder = writable_folder()
    key = content_key([SOURCE.read_text(), tool.path, tool.version, *FLAGS])
    library = folder / f"dormand_prince-{key}.so"
    if intact(library):
        return library
    with locked(folder, key), tempfile.TemporaryDirectory(dir=folder, prefix="build-") as work:
        output = Path(work, "dormand_prince.so")
        tool.build(SOURCE, output, FLAGS)
        seal(output)
        os.replace(output, library)
    return library
