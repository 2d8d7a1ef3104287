"""Casadi functions (t, x, p) bound to fixed parameters and to memory of their own.

A call through casadi's buffers costs a microsecond where the ordinary one, which converts every argument, costs tens;
C code calls through casadi's C interface, which costs as little.
"""

from __future__ import annotations

import contextlib
import ctypes
import functools
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.simulation.casadi_c import Loaded, interface, loaded
from amble.simulation.library import DOUBLES, doubles, load
from amble.types import NodeValues, Vector

SAFE = ("SXFunction", "External")
"""Straight-line arithmetic, and compiled code, which returns a status."""


def may_throw(function: ca.Function) -> bool:
    """Whether a function holds anything but arithmetic and compiled code: a solver, an assertion, a callback in Python.

    Such a function is evaluated through Python, where its failure is caught.
    """
    if function.class_name() in SAFE:
        return False
    if not function.is_a("MXFunction"):
        return True
    for place in range(function.n_instructions()):
        kind = function.instruction_id(place)
        if kind == ca.OP_ASSERTION:
            return True
        if kind == ca.OP_CALL and may_throw(function.instruction_MX(place).which_function()):
            return True
    return False


class Callee(ctypes.Structure):
    """What C code calls: the structure of ``callee.h``."""

    _fields_ = (
        ("evaluate", ctypes.c_void_p),
        ("arguments", ctypes.c_void_p),
        ("outputs", ctypes.c_void_p),
        ("integers", ctypes.c_void_p),
        ("reals", ctypes.c_void_p),
        ("id", ctypes.c_int),
        ("memory", ctypes.c_int),
        ("clock", DOUBLES),
        ("state", DOUBLES),
        ("results", ctypes.POINTER(DOUBLES)),
        ("widths", ctypes.POINTER(ctypes.c_int)),
        ("n", ctypes.c_int),
        ("n_results", ctypes.c_int),
    )


ARGUMENTS = (
    ctypes.POINTER(Callee), ctypes.c_int, DOUBLES, DOUBLES, ctypes.POINTER(DOUBLES),
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class Bound:
    """A function with its parameters, and the arrays that casadi reads and writes at every call.

    ``throws`` says that the function may fail by an exception; where it does, its results are not numbers.
    """

    function: ca.Function
    buffer: ca.FunctionBuffer
    evaluate: Any
    clock: Vector
    state: Vector
    parameters: Vector
    results: tuple[Vector, ...]
    throws: bool

    def __call__(self, clock: float, state: Vector) -> tuple[Vector, ...]:
        """Return all results of the function, flat."""
        self._call(clock, state)
        return tuple(result.copy() for result in self.results)

    def along(self, clock: Vector, state: NodeValues) -> tuple[NodeValues, ...]:
        """Return all results at many samples, each (n, width).

        Args:
            clock: (n,), s.
            state: (n, n_x).

        Raises:
            InputError: where the shapes do not fit.
        """
        clock, state = (np.ascontiguousarray(values, dtype=np.float64) for values in (clock, state))
        if clock.ndim != 1 or state.shape != (clock.size, self.state.size):
            raise InputError(
                f"samples have clocks of shape {clock.shape} and states of shape {state.shape}, "
                f"not (n,) and (n, {self.state.size})"
            )
        collected = tuple(np.empty((clock.size, result.size)) for result in self.results)
        library = None if self.throws else load("along")
        if library is not None and self.callee is not None:
            self._along(library.amble_along, self.callee, clock, state, collected)
            return collected
        for row in range(clock.size):
            self._call(clock[row], state[row])
            for values, result in zip(collected, self.results, strict=True):
                values[row] = result
        return collected

    @functools.cached_property
    def callee(self) -> Callee | None:
        """What C code calls, None where it cannot; it points to the memory of this object, which must outlive it."""
        taken, library = self._taken, interface()
        if taken is None or library is None:
            return None
        count = len(self.results)
        taken.arguments[:3] = [_place(array) for array in (self.clock, self.state, self.parameters)]
        taken.results[:count] = [_place(array) for array in self.results]
        return Callee(
            ctypes.cast(library.casadi_c_eval_id, ctypes.c_void_p),
            *(ctypes.addressof(work) for work in (taken.arguments, taken.results, taken.integers, taken.reals)),
            taken.held.number,
            taken.memory,
            doubles(self.clock),
            doubles(self.state),
            (DOUBLES * count)(*map(doubles, self.results)),
            (ctypes.c_int * count)(*(result.size for result in self.results)),
            self.state.size,
            count,
        )

    @functools.cached_property
    def _taken(self) -> Loaded | None:
        return loaded(self.function)

    def _along(
        self, routine: Any, callee: Callee, clock: Vector, state: NodeValues, collected: tuple[NodeValues, ...]
    ) -> None:
        """Fill ``collected`` in one call of ``along.c``."""
        pointers = DOUBLES * len(self.results)
        routine.argtypes, routine.restype = ARGUMENTS, None
        routine(ctypes.byref(callee), clock.size, doubles(clock), doubles(state), pointers(*map(doubles, collected)))

    def _call(self, clock: float, state: Vector) -> None:
        self.clock[0] = clock
        self.state[:] = state
        for result in self.results:
            result[:] = np.nan  # a function that fails writes nothing: it must not look like its last value
        with contextlib.suppress(RuntimeError):
            self.evaluate()


def bind(function: ca.Function, parameters: Vector) -> Bound:
    """Bind a function (t, x, p) to the value of p.

    Raises:
        InputError: where p has another size.
    """
    if function.numel_in(2) != np.size(parameters):
        raise InputError(
            f"function '{function.name()}' takes {function.numel_in(2)} parameters, not {np.size(parameters)}"
        )
    dense = _dense(function)
    buffer, evaluate = dense.buffer()
    clock, state, values = np.zeros(1), np.zeros(dense.numel_in(1)), np.array(parameters, dtype=np.float64)
    results = tuple(np.zeros(dense.numel_out(i)) for i in range(dense.n_out()))
    for position, array in enumerate((clock, state, values)):
        if array.size:
            buffer.set_arg(position, array.data)
    for position, array in enumerate(results):
        if array.size:
            buffer.set_res(position, array.data)
    return Bound(
        function=dense,
        buffer=buffer,
        evaluate=evaluate,
        clock=clock,
        state=state,
        parameters=values,
        results=results,
        throws=may_throw(dense),
    )


def _place(array: Vector) -> int | None:
    """Address of an array, null for an empty one."""
    return int(array.ctypes.data) if array.size else None


def _dense(function: ca.Function) -> ca.Function:
    """Return the function itself, or one with dense arguments and results: buffers hold only structural nonzeros."""
    sparsities = [
        *(function.sparsity_in(i) for i in range(3)),
        *(function.sparsity_out(i) for i in range(function.n_out())),
    ]
    if all(sparsity.is_dense() for sparsity in sparsities):
        return function
    symbols = [ca.MX.sym(name, *function.size_in(i)) for i, name in enumerate("txp")]
    values = function.call(symbols)
    names = function.name_out()
    return ca.Function(f"{function.name()}_dense", symbols, [ca.densify(value) for value in values], list("txp"), names)
