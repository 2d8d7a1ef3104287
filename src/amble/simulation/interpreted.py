"""The flow through a domain where there is no C compiler: scipy's DOP853, with the same rule for guards."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from amble.hybrid.system import numeric
from amble.simulation.flow import (
    EVENT_SAMPLES,
    MOST_STEPS,
    RESOLUTION,
    STUCK,
    TOO_LONG,
    Arc,
    EventFunction,
    FlowDefinition,
)
from amble.types import Vector

Motion = Callable[[float], Vector]


@dataclass(frozen=True)
class InterpretedFlow:
    """A prepared flow."""

    definition: FlowDefinition

    def __call__(self, start: Vector, tolerance: float, time_limit: float, samples: int) -> Arc:
        """Integrate from a state at clock 0 until an event fires or the flow has lasted ``time_limit`` (s)."""
        entry = np.array(start, dtype=np.float64)
        pieces: list[Any] = []
        try:
            with np.errstate(all="ignore"):  # what is not finite is reported, not warned about
                crossing = self._integrate(entry, tolerance, time_limit, pieces)
        except FloatingPointError:
            return _arc(pieces, entry, samples, pieces[-1].t if pieces else 0.0, None, STUCK)
        if crossing is None:
            return _arc(pieces, entry, samples, time_limit, None, TOO_LONG)
        which, ended = self.definition.outcome(crossing[0])
        return _arc(pieces, entry, samples, crossing[1], which, ended)

    def _integrate(
        self, start: Vector, tolerance: float, time_limit: float, pieces: list[Any]
    ) -> tuple[int, float] | None:
        """Step from breakpoint to breakpoint, collecting the dense output; returns the first crossing (guard, clock).

        Raises:
            FloatingPointError: where the motion cannot go on.
        """
        from scipy.integrate import DOP853

        values = np.full(len(self.definition.events), np.nan)
        clock, state = 0.0, start
        for limit in (*(at for at in self.definition.breakpoints if at < time_limit), time_limit):
            stepper = DOP853(self._rate, clock, state, limit, rtol=tolerance, atol=tolerance)
            while stepper.status == "running":
                stepper.step()
                if stepper.status == "failed" or len(pieces) >= MOST_STEPS:
                    raise FloatingPointError
                pieces.append(stepper.dense_output())
                crossing = self._look(pieces[-1], values)
                if crossing is not None:
                    return crossing
            clock, state = stepper.t, stepper.y
        return None

    def _rate(self, clock: float, state: Vector) -> Vector:
        return numeric(self._evaluated(self.definition.field, clock, state))

    def _value(self, item: EventFunction, clock: float, state: Vector) -> float:
        return item.direction * float(self._evaluated(item.function, clock, state))

    def _evaluated(self, function: ca.Function, clock: float, state: Vector) -> Any:
        try:
            return function(clock, state, self.definition.parameters)
        except RuntimeError:  # a solver inside did not converge, an assertion does not hold
            raise FloatingPointError from None

    def _look(self, piece: Any, values: Vector) -> tuple[int, float] | None:
        """Look at the guards along a step, keeping their last values; returns the first crossing (guard, clock)."""
        earlier = piece.t_old
        for clock in piece.t_old + (piece.t - piece.t_old) * np.arange(1, EVENT_SAMPLES + 1) / EVENT_SAMPLES:
            roots = []
            for guard, item in enumerate(self.definition.events):
                start = max(earlier, item.dead_time, RESOLUTION)
                if clock <= start:
                    continue
                before = self._value(item, start, piece(start)) if np.isnan(values[guard]) else values[guard]
                values[guard] = self._value(item, clock, piece(clock))
                if np.isnan(before) or np.isnan(values[guard]):
                    raise FloatingPointError
                if before < 0 <= values[guard]:
                    roots.append((self._root(piece, item, start, clock), guard))
            if roots:
                when, guard = min(roots)
                return guard, when
            earlier = clock
        return None

    def _root(self, piece: Any, item: EventFunction, earlier: float, later: float) -> float:
        from scipy.optimize import brentq

        def value(clock: float) -> float:
            return self._value(item, clock, piece(clock))

        return float(brentq(value, earlier, later, xtol=1e-15, rtol=1e-15, maxiter=1000))


def prepare(definition: FlowDefinition) -> InterpretedFlow:
    """Prepare a flow."""
    return InterpretedFlow(definition)


def _arc(pieces: Sequence[Any], start: Vector, samples: int, end: float, fired: int | None, ended: str) -> Arc:
    clock = np.linspace(0.0, end, samples)
    starts = [piece.t_old for piece in pieces]
    state = np.tile(np.array(start, dtype=np.float64), (samples, 1))
    for row, moment in enumerate(clock):
        if pieces:
            state[row] = pieces[max(int(np.searchsorted(starts, moment, side="right")) - 1, 0)](moment)
    return Arc(clock, state, fired, ended, len(pieces))
