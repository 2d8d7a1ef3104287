"""The flow through a domain where there is no C compiler: scipy's DOP853, with the same rule for guards."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import casadi as ca
import numpy as np

from amble.hybrid.system import numeric
from amble.simulation.flow import LOOKS, MOST_STEPS, RESOLUTION, STUCK, TOO_LONG, Course, Passage, Watched
from amble.types import Vector

Motion = Callable[[float], Vector]


@dataclass(frozen=True)
class InterpretedFlow:
    """A prepared flow."""

    course: Course

    def __call__(self, start: Vector, tolerance: float, longest: float, samples: int) -> Passage:
        """Integrate from a state at clock 0 until a watched function fires or the flow has lasted ``longest`` (s)."""
        entry = np.array(start, dtype=np.float64)
        pieces: list[Any] = []
        try:
            with np.errstate(all="ignore"):  # what is not finite is reported, not warned about
                crossing = self._integrate(entry, tolerance, longest, pieces)
        except FloatingPointError:
            return _passage(pieces, entry, samples, pieces[-1].t if pieces else 0.0, None, STUCK)
        if crossing is None:
            return _passage(pieces, entry, samples, longest, None, TOO_LONG)
        which, ended = self.course.outcome(crossing[0])
        return _passage(pieces, entry, samples, crossing[1], which, ended)

    def _integrate(
        self, start: Vector, tolerance: float, longest: float, pieces: list[Any]
    ) -> tuple[int, float] | None:
        """Step from kink to kink, collecting the dense output; returns the first crossing (guard, clock).

        Raises:
            FloatingPointError: where the motion cannot go on.
        """
        from scipy.integrate import DOP853

        values = np.full(len(self.course.watched), np.nan)
        clock, state = 0.0, start
        for limit in (*(kink for kink in self.course.kinks if kink < longest), longest):
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
        return numeric(self._evaluated(self.course.field, clock, state))

    def _value(self, item: Watched, clock: float, state: Vector) -> float:
        return item.direction * float(self._evaluated(item.function, clock, state))

    def _evaluated(self, function: ca.Function, clock: float, state: Vector) -> Any:
        try:
            return function(clock, state, self.course.parameters)
        except RuntimeError:  # a solver inside did not converge, an assertion does not hold
            raise FloatingPointError from None

    def _look(self, piece: Any, values: Vector) -> tuple[int, float] | None:
        """Look at the guards along a step, keeping their last values; returns the first crossing (guard, clock)."""
        earlier = piece.t_old
        for clock in piece.t_old + (piece.t - piece.t_old) * np.arange(1, LOOKS + 1) / LOOKS:
            roots = []
            for guard, item in enumerate(self.course.watched):
                start = max(earlier, item.earliest, RESOLUTION)
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

    def _root(self, piece: Any, item: Watched, earlier: float, later: float) -> float:
        from scipy.optimize import brentq

        def value(clock: float) -> float:
            return self._value(item, clock, piece(clock))

        return float(brentq(value, earlier, later, xtol=1e-15, rtol=1e-15, maxiter=1000))


def prepare(course: Course) -> InterpretedFlow:
    """Prepare a flow."""
    return InterpretedFlow(course)


def _passage(pieces: Sequence[Any], start: Vector, samples: int, end: float, fired: int | None, ended: str) -> Passage:
    clock = np.linspace(0.0, end, samples)
    starts = [piece.t_old for piece in pieces]
    state = np.tile(np.array(start, dtype=np.float64), (samples, 1))
    for row, moment in enumerate(clock):
        if pieces:
            state[row] = pieces[max(int(np.searchsorted(starts, moment, side="right")) - 1, 0)](moment)
    return Passage(clock, state, fired, ended, len(pieces))
