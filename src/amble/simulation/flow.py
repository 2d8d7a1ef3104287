"""The flow through one domain: from an entry state until a guard fires.

Two ways compute it, by the same method and the same rule for guards: native code (``native``), and scipy where there
is no C compiler (``interpreted``). The rule: a guard fires where it passes zero in its direction at a clock t with
0 < t <= t_end. Guards are looked at four times a step and located on the dense output; the first look is at
``RESOLUTION`` (or ``Transition.dead_time``), so that a guard which is zero at the start, exactly or within roundoff,
does not fire there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import casadi as ca

from amble.types import NodeValues, Vector

RESOLUTION = 1e-10
"""Clock of the first look at the guards, and the accuracy to which events are located at least, s."""

EVENT_SAMPLES = 4
"""How often a step looks at the guards; a guard that crosses and returns between two looks is not seen."""

LEFT_DOMAIN = "fell"
TOO_LONG = "reached no guard"
MOST_STEPS = 10000
"""Steps of one arc: a motion of a walker takes about a hundred, and all of them are kept for its dense output."""

STUCK = "cannot go on (its rate is not a number or fails, grows without bound or is too stiff)"


@dataclass(frozen=True)
class Arc:
    """The motion through one domain.

    Attributes:
        clock: of the samples, evenly spaced from the entry to the end, (n,), s.
        state: at the samples, (n, n_x).
        fired: position of the transition that fired among those that leave the domain; None where none did.
        ended: why no transition fired, else empty: one of LEFT_DOMAIN, TOO_LONG, STUCK.
        steps: accepted steps of the integrator; each took 15 evaluations of the vector field.
    """

    clock: Vector
    state: NodeValues
    fired: int | None
    ended: str
    steps: int


class Flow(Protocol):
    """A prepared domain."""

    def __call__(self, start: Vector, tolerance: float, time_limit: float, samples: int) -> Arc:
        """Integrate from a state at clock 0 until a transition fires or the domain has lasted ``time_limit`` (s)."""


@dataclass(frozen=True)
class EventFunction:
    """A function whose zero is an event, looked for from its dead time on: +1 where it fires rising, -1 falling."""

    function: ca.Function
    direction: int
    dead_time: float


@dataclass(frozen=True)
class FlowDefinition:
    """What a flow follows, and the events that end it.

    Attributes:
        field: casadi function (t, x, p) -> dx/dt.
        parameters: p.
        events: functions (t, x, p) whose zeros end the flow.
        has_margin: whether the last event is that of the margin of the domain of admissibility.
        breakpoints: clocks at which a step has to end, positive and ascending (``Domain.breakpoints``).
    """

    field: ca.Function
    parameters: Vector
    events: tuple[EventFunction, ...] = ()
    has_margin: bool = False
    breakpoints: tuple[float, ...] = ()

    def outcome(self, fired: int) -> tuple[int | None, str]:
        """Tell a transition from a fall."""
        fell = self.has_margin and fired == len(self.events) - 1
        return (None, LEFT_DOMAIN) if fell else (fired, "")
