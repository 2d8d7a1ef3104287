"""The flow through a domain where there is no C compiler: scipy's DOP853, with the same rule for guards."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from amble.hybrid.system import numeric
from amble.simulation.flow import MOST_STEPS, STEEP, STUCK, TOO_LONG, Arc, FlowDefinition
from amble.simulation.watch import SteepError, evaluated, look
from amble.types import Vector


@dataclass(frozen=True)
class InterpretedFlow:
    """A prepared flow."""

    definition: FlowDefinition

    def __call__(self, start: Vector, tolerance: float, time_limit: float, samples: int, max_step: float) -> Arc:
        """Integrate from a state at clock 0 until an event fires; see ``Flow``."""
        entry = np.array(start, dtype=np.float64)
        pieces: list[Any] = []
        try:
            with np.errstate(all="ignore"):  # what is not finite is reported, not warned about
                crossing = self._integrate(entry, tolerance, time_limit, max_step, pieces)
        except SteepError:
            return _arc(pieces, entry, samples, pieces[-1].t_old, None, STEEP)
        except FloatingPointError:
            return _arc(pieces, entry, samples, pieces[-1].t if pieces else 0.0, None, STUCK)
        if crossing is None:
            return _arc(pieces, entry, samples, time_limit, None, TOO_LONG)
        which, ended = self.definition.outcome(crossing[0])
        return _arc(pieces, entry, samples, crossing[1], which, ended)

    def _integrate(
        self, start: Vector, tolerance: float, time_limit: float, max_step: float, pieces: list[Any]
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
                crossing = look(self.definition, pieces[-1], max_step, values)
                if crossing is not None:
                    return crossing
            clock, state = stepper.t, stepper.y
        return None

    def _rate(self, clock: float, state: Vector) -> Vector:
        return numeric(evaluated(self.definition.field, clock, state, self.definition.parameters))


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
