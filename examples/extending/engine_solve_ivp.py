"""An engine of one's own: scipy's multistep method, with its own location of events. One class, one registration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np
from scipy.integrate import solve_ivp

from amble.hybrid import HybridSystem
from amble.simulation.flow import LEFT_DOMAIN, RESOLUTION, STUCK, TOO_LONG, Arc, EventFunction
from amble.simulation.prepared import event_functions
from amble.simulation.walk import ENGINES, walk
from amble.types import Vector


@dataclass(frozen=True)
class MultistepFlow:
    """The flow through one domain; ``walk`` does what is common to all: resets, the order of domains, cycles."""

    system: HybridSystem
    name: str

    def __call__(self, start: Vector, tolerance: float, time_limit: float, samples: int, max_step: float) -> Arc:
        """Integrate from a state at clock 0 until an event fires or the flow has lasted ``time_limit`` (s)."""
        domain = self.system.domain(self.name)
        events = event_functions(domain, self.system.leaving(self.name))

        def rate(clock: float, state: Vector) -> Vector:
            return np.asarray(domain.field(clock, state, domain.parameters)).ravel()

        found = solve_ivp(
            rate,
            (0.0, time_limit),
            np.array(start),
            method="LSODA",
            rtol=tolerance,
            atol=tolerance,
            max_step=max_step,
            dense_output=True,
            events=[_event(event, domain.parameters) for event in events],
        )
        fired = next((number for number, times in enumerate(found.t_events) if times.size), None)
        clock = np.linspace(0.0, found.t[-1], samples)
        state = found.sol(clock).T
        if fired is None:
            return Arc(clock, state, None, TOO_LONG if found.status == 0 else STUCK, found.t.size)
        if domain.admissibility is not None and fired == len(events) - 1:
            return Arc(clock, state, None, LEFT_DOMAIN, found.t.size)
        return Arc(clock, state, fired, "", found.t.size)


def _event(event: EventFunction, parameters: Vector) -> Callable[[float, Vector], float]:
    """Write an event as scipy has it, rising through zero; positive before its dead time, where it must not fire."""
    first = max(event.dead_time, RESOLUTION)

    def value(clock: float, state: Vector) -> float:
        return 1.0 if clock < first else event.direction * float(event.function(clock, state, parameters))

    value.terminal = True  # type: ignore[attr-defined]
    value.direction = 1.0  # type: ignore[attr-defined]
    return value


ENGINES.register("solve_ivp", partial(walk, prepare=MultistepFlow))
