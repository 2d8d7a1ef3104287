"""The flow through a domain in native code: one call of ``dormand_prince.c`` a domain."""

from __future__ import annotations

import ctypes
from dataclasses import dataclass
from typing import Any

import numpy as np

from amble.errors import WorkError
from amble.numerics.runge_kutta import dop853
from amble.simulation.bound import Callee, bind
from amble.simulation.flow import RESOLUTION, STEEP, STUCK, TOO_LONG, Arc, Flow, FlowDefinition
from amble.simulation.library import DOUBLES, doubles, load
from amble.types import Vector

CROSSED, NO_MEMORY = 0, 3
REASONS = {1: TOO_LONG, 2: STUCK, 4: STEEP}

TABLEAU = ("a", "c", "error3", "error5", "dense")
"""The arrays of the method, in the order of the C structure."""


class Tableau(ctypes.Structure):
    """``Tableau`` of dormand_prince.c."""

    _fields_ = tuple((name, DOUBLES) for name in TABLEAU)


class Problem(ctypes.Structure):
    """``Problem`` of dormand_prince.c."""

    _fields_ = (
        ("field", ctypes.POINTER(Callee)),
        ("guards", ctypes.POINTER(Callee)),
        ("sign", DOUBLES),
        ("first", DOUBLES),
        ("steepest", DOUBLES),
        ("breakpoints", DOUBLES),
        ("n", ctypes.c_int),
        ("n_guards", ctypes.c_int),
        ("n_breakpoints", ctypes.c_int),
    )


ARGUMENTS = (
    ctypes.POINTER(Problem), ctypes.POINTER(Tableau), DOUBLES, ctypes.c_double, ctypes.c_double, ctypes.c_double,
    ctypes.c_int, DOUBLES, DOUBLES, ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_int),
    ctypes.POINTER(ctypes.c_int),
)  # fmt: skip


@dataclass(frozen=True)
class NativeFlow:
    """A prepared flow; ``kept`` holds the memory that the C structures point to."""

    definition: FlowDefinition
    routine: Any
    problem: Problem
    tableau: Tableau
    kept: tuple[Any, ...]

    def __call__(self, start: Vector, tolerance: float, time_limit: float, samples: int, max_step: float) -> Arc:
        """Integrate from a state at clock 0 until an event fires; see ``Flow``."""
        entry = np.array(start, dtype=np.float64)
        clock, state = np.zeros(samples), np.tile(entry, (samples, 1))
        end, fired, steps = ctypes.c_double(), ctypes.c_int(), ctypes.c_int()
        status = self.routine(
            ctypes.byref(self.problem), ctypes.byref(self.tableau), doubles(entry), tolerance, time_limit,
            max_step, samples, doubles(clock), doubles(state), ctypes.byref(end), ctypes.byref(fired),
            ctypes.byref(steps),
        )  # fmt: skip
        if status == NO_MEMORY:
            raise WorkError(f"the simulation of '{self.definition.field.name()}' ran out of memory")
        if status != CROSSED:
            return Arc(clock, state, None, REASONS[status], steps.value)
        which, ended = self.definition.outcome(fired.value)
        return Arc(clock, state, which, ended, steps.value)


def prepare(definition: FlowDefinition) -> Flow | None:
    """Prepare a flow; None where there is no library, or a function might throw or cannot be called from C."""
    library = load("dormand_prince")
    if library is None:
        return None
    followed = bind(definition.field, definition.parameters)
    events = [bind(item.function, definition.parameters) for item in definition.events]
    if any(bound.throws for bound in (followed, *events)):
        return None
    field, watched = followed.callee, [bound.callee for bound in events if bound.callee is not None]
    if field is None or len(watched) < len(events):
        return None
    routine = library.amble_flow
    routine.argtypes, routine.restype = ARGUMENTS, ctypes.c_int
    guards = (Callee * len(events))(*watched)
    sign = np.array([float(item.direction) for item in definition.events])
    first = np.array([max(item.dead_time, RESOLUTION) for item in definition.events])
    steepest = np.array([item.slope_bound for item in definition.events])
    breakpoints = np.array(definition.breakpoints)
    problem = Problem(
        ctypes.pointer(field), ctypes.cast(guards, ctypes.POINTER(Callee)), doubles(sign),
        doubles(first), doubles(steepest), doubles(breakpoints), definition.field.numel_in(1), len(events),
        breakpoints.size,
    )  # fmt: skip
    method = dop853()
    arrays = tuple(np.array(getattr(method, name)) for name in TABLEAU)
    kept = (followed, events, field, guards, sign, first, steepest, breakpoints, arrays)
    return NativeFlow(definition, routine, problem, Tableau(*map(doubles, arrays)), kept)
