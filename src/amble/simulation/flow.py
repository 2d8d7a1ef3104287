"""The flow through one domain: from an entry state until a guard fires.

Two ways compute it, by the same method and the same rule for guards: native code (``native``), and scipy where there
is no C compiler (``interpreted``). The rule: a guard fires where it passes zero in its direction at a clock t with
0 < t <= t_end. Guards are looked at on the dense output and located there; the first sample is at ``RESOLUTION`` (or
``Transition.dead_time``), so that a guard which is zero at the start, exactly or within roundoff, does not fire there.

A guard that passes zero and returns between two event samples shows only in its values around. So:
- event samples are at least four a step and at most ``max_step`` apart: no excursion that lasts longer is missed;
- the slopes of the polynomial through five samples tell where the guard turns towards zero and back between two,
  and the extreme there is searched for: an excursion of a guard that is smooth on the scale of its samples is found,
  however short;
- where the guard's slope is bounded (``Transition.slope_bound``), every interval in which the bound leaves room for a
  zero is halved until it does not: no excursion is missed, down to ``RESOLUTION``.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import inf
from typing import Protocol

import casadi as ca

from amble.types import NodeValues, Vector

RESOLUTION = 1e-10
"""Clock of the first event sample, and the accuracy to which events are located at least, s."""

EVENT_SAMPLES = 4
"""The fewest event samples of a step."""

EVENT_SAMPLES_IN_TIME_LIMIT = 1000
"""Without a ``max_step``, event samples are this share of the time limit apart, or closer."""

LEFT_DOMAIN = "fell"
TOO_LONG = "reached no guard"
MOST_STEPS = 10000
"""Steps of one arc: a motion of a walker takes about a hundred, and all of them are kept for its dense output."""

STEEP = "has a guard that is steeper than its slope bound"
STUCK = "cannot go on (its rate is not a number or fails, grows without bound or is too stiff)"


@dataclass(frozen=True)
class Arc:
    """The motion through one domain.

    Attributes:
        clock: of the samples, evenly spaced from the entry to the end, (n,), s.
        state: at the samples, (n, n_x).
        fired: position of the transition that fired among those that leave the domain; None where none did.
        ended: why no transition fired, else empty: LEFT_DOMAIN, TOO_LONG, STEEP, STUCK or one of ``Domain.margins``.
        steps: accepted steps of the integrator; each took 15 evaluations of the vector field.
    """

    clock: Vector
    state: NodeValues
    fired: int | None
    ended: str
    steps: int


class Flow(Protocol):
    """A prepared domain."""

    def __call__(self, start: Vector, tolerance: float, time_limit: float, samples: int, max_step: float) -> Arc:
        """Integrate from a state at clock 0 until a transition fires or the domain has lasted ``time_limit`` (s).

        Args:
            start: the state, (n_x,).
            tolerance: relative and absolute.
            time_limit: s.
            samples: of the arc, evenly spaced in time.
            max_step: the longest time between two event samples, s.
        """


@dataclass(frozen=True)
class EventFunction:
    """A function whose zero is an event, looked for from its dead time on: +1 where it fires rising, -1 falling."""

    function: ca.Function
    direction: int
    dead_time: float
    slope_bound: float = inf


@dataclass(frozen=True)
class FlowDefinition:
    """What a flow follows, and the events that end it.

    Attributes:
        field: casadi function (t, x, p) -> dx/dt.
        parameters: p.
        events: functions (t, x, p) whose zeros end the flow.
        margins: what the last events mean, those of the margins of the domain of admissibility (``LEFT_DOMAIN``).
        breakpoints: clocks at which a step has to end, positive and ascending (``Domain.breakpoints``).
    """

    field: ca.Function
    parameters: Vector
    events: tuple[EventFunction, ...] = ()
    margins: tuple[str, ...] = ()
    breakpoints: tuple[float, ...] = ()

    def outcome(self, fired: int) -> tuple[int | None, str]:
        """Tell a transition from the end of the motion."""
        place = fired - (len(self.events) - len(self.margins))
        return (None, self.margins[place]) if place >= 0 else (fired, "")
