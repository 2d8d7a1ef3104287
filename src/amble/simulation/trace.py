"""The record of a simulated motion: samples along every domain and the events between them."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from amble.types import IntegerVector, NodeValues, Vector

COMPLETED = "completed"


@dataclass(frozen=True)
class Event:
    """One passage from a domain to the next.

    Attributes:
        time: time since the start of the simulation, s.
        transition: name of the transition.
        before: state just before the reset, (n_x,).
        after: state just after it, (n_x,).
    """

    time: float
    transition: str
    before: Vector
    after: Vector


@dataclass(frozen=True, kw_only=True)
class Trace:
    """A simulated motion.

    Attributes:
        domains: names of the domains of the hybrid system that was simulated.
        state_names: names of the states, (n_x,).
        time: time of every sample, (n,), s; an event has a sample just before and one just after it.
        clock: time since the entry of the domain, (n,), s.
        domain: index into ``domains`` of every sample, (n,).
        cycle: number of the cycle of every sample, from 0, (n,).
        state: (n, n_x).
        signals: the signals that the domains declare, name -> (n, width).
        events: in order of time.
        cycles: number of completed cycles.
        ended: "completed", or one sentence that says why and when the motion ended early (a fall, a lost rank).
        tolerance: relative and absolute tolerance of the integrator.
        seconds: wall time of the simulation, s.
    """

    domains: tuple[str, ...]
    state_names: tuple[str, ...]
    time: Vector
    clock: Vector
    domain: IntegerVector
    cycle: IntegerVector
    state: NodeValues
    signals: Mapping[str, NodeValues]
    events: tuple[Event, ...]
    cycles: int
    ended: str
    tolerance: float
    seconds: float

    def __post_init__(self) -> None:
        """Make the arrays read-only, so that the record stays as it was made."""
        for array in (self.time, self.clock, self.domain, self.cycle, self.state, *self.signals.values()):
            array.setflags(write=False)

    @property
    def completed(self) -> bool:
        """Whether every cycle that was asked for was walked."""
        return self.ended == COMPLETED

    @property
    def section(self) -> NodeValues:
        """States on the Poincare section: the entry of the first domain in every completed cycle and after the last.

        Shape (cycles + 1, n_x).
        """
        first = np.searchsorted(self.cycle, np.arange(self.cycles + 1))
        entries = [self.state[row] if row < self.cycle.size else self.events[-1].after for row in first]
        return np.array(entries)
