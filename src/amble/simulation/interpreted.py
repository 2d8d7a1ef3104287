"""The flow through a domain where there is no C compiler: scipy's DOP853, with the same rule for guards."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from amble.hybrid import Domain
from amble.hybrid.system import numeric
from amble.simulation.flow import LOOKS, NOT_FINITE, RESOLUTION, STALLED, TOO_LONG, Passage, Watched, outcome
from amble.types import Vector

Motion = Callable[[float], Vector]


@dataclass(frozen=True)
class InterpretedFlow:
    """A prepared domain."""

    domain: Domain
    watched: tuple[Watched, ...]

    def __call__(self, start: Vector, tolerance: float, longest: float, samples: int) -> Passage:
        """Integrate from a state at clock 0 until a transition fires or the domain has lasted ``longest`` (s)."""
        from scipy.integrate import DOP853

        def rate(clock: float, state: Vector) -> Vector:
            return numeric(self.domain.field(clock, state, self.domain.parameters))

        with np.errstate(all="ignore"):  # what is not finite is reported, not warned about
            stepper = DOP853(rate, 0.0, np.array(start, dtype=np.float64), longest, rtol=tolerance, atol=tolerance)
            pieces: list[Any] = []
            values: Vector | None = None
            while stepper.status == "running":
                stepper.step()
                if stepper.status == "failed":
                    break
                pieces.append(stepper.dense_output())
                values, crossing = self._look(pieces[-1], values)
                if not np.all(np.isfinite(values)):
                    stepper.status = "failed"
                elif crossing is not None:
                    which, ended = outcome(self.domain, len(self.watched), crossing[0])
                    return _passage(pieces, start, crossing[1], samples, which, ended)
        if stepper.status == "finished":
            return _passage(pieces, start, longest, samples, None, TOO_LONG)
        ended = STALLED if np.all(np.isfinite(rate(stepper.t, stepper.y))) else NOT_FINITE
        return _passage(pieces, start, pieces[-1].t if pieces else 0.0, samples, None, ended)

    def _value(self, item: Watched, clock: float, state: Vector) -> float:
        return item.direction * float(item.function(clock, state, self.domain.parameters))

    def _look(self, piece: Any, before: Vector | None) -> tuple[Vector, tuple[int, float] | None]:
        """Look at the guards along a step; returns their last values and the first crossing (guard, clock)."""
        length = piece.t - piece.t_old
        clocks = piece.t_old + length * np.arange(1, LOOKS + 1) / LOOKS
        earlier = piece.t_old
        if before is None:
            earlier = min(RESOLUTION, 0.5 * length / LOOKS)
            before = np.array([self._value(item, earlier, piece(earlier)) for item in self.watched])
        for clock in clocks:
            now = np.array([self._value(item, clock, piece(clock)) for item in self.watched])
            crossed = np.flatnonzero((before < 0) & (now >= 0))
            roots = [(self._root(piece, self.watched[guard], earlier, clock), int(guard)) for guard in crossed]
            if roots:
                when, guard = min(roots)
                return now, (guard, when)
            before, earlier = now, clock
        return before, None

    def _root(self, piece: Any, item: Watched, earlier: float, later: float) -> float:
        from scipy.optimize import brentq

        def value(clock: float) -> float:
            return self._value(item, clock, piece(clock))

        return float(brentq(value, earlier, later, xtol=1e-15, rtol=1e-15))


def prepare(domain: Domain, watched: Sequence[Watched]) -> InterpretedFlow:
    """Prepare a domain."""
    return InterpretedFlow(domain, tuple(watched))


def _passage(pieces: Sequence[Any], start: Vector, end: float, samples: int, fired: int | None, ended: str) -> Passage:
    clock = np.linspace(0.0, end, samples)
    starts = [piece.t_old for piece in pieces]
    state = np.tile(np.array(start, dtype=np.float64), (samples, 1))
    for row, moment in enumerate(clock):
        if pieces:
            state[row] = pieces[max(int(np.searchsorted(starts, moment, side="right")) - 1, 0)](moment)
    return Passage(clock, state, fired, ended, len(pieces))
