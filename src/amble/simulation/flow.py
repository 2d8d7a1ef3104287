"""The flow through one domain: from an entry state until a guard fires.

Two ways compute it, by the same method and the same rule for guards: native code (``native``), and scipy where there
is no C compiler (``interpreted``). The rule: a guard fires where it passes zero in its direction at a clock t with
0 < t <= t_end. Guards are looked at four times a step and located on the dense output; the first look is at
``RESOLUTION`` (or ``Transition.earliest``), so that a guard which is zero at the start, exactly or within roundoff,
does not fire there.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import casadi as ca

from amble.hybrid import Domain, HybridSystem, Transition
from amble.types import NodeValues, Vector

RESOLUTION = 1e-10
"""Clock of the first look at the guards, and the accuracy to which events are located at least, s."""

LOOKS = 4
"""How often a step looks at the guards; a guard that crosses and returns between two looks is not seen."""

FELL = "fell"
TOO_LONG = "reached no guard"
MOST_STEPS = 10000
"""Steps of one passage: a motion of a walker takes about a hundred, and all of them are kept for its dense output."""

STUCK = "cannot go on (its rate is not a number or fails, grows without bound or is too stiff)"


@dataclass(frozen=True)
class Passage:
    """The motion through one domain.

    Attributes:
        clock: of the samples, evenly spaced from the entry to the end, (n,), s.
        state: at the samples, (n, n_x).
        fired: position of the transition that fired among those that leave the domain; None where none did.
        ended: why no transition fired, else empty: one of FELL, TOO_LONG, STUCK.
        steps: accepted steps of the integrator; each took 15 evaluations of the vector field.
    """

    clock: Vector
    state: NodeValues
    fired: int | None
    ended: str
    steps: int


class Flow(Protocol):
    """A prepared domain."""

    def __call__(self, start: Vector, tolerance: float, longest: float, samples: int) -> Passage:
        """Integrate from a state at clock 0 until a transition fires or the domain has lasted ``longest`` (s)."""


@dataclass(frozen=True)
class Watched:
    """A function whose zero is watched from a clock on: +1 where it fires rising, -1 where it fires falling."""

    function: ca.Function
    direction: int
    earliest: float


@dataclass(frozen=True)
class Course:
    """What a flow follows and watches.

    Attributes:
        field: casadi function (t, x, p) -> dx/dt.
        parameters: p.
        watched: functions (t, x, p) whose zeros end the flow.
        mortal: whether the last function watched is a margin to a fall.
        kinks: clocks at which a step has to end, positive and ascending (``Domain.kinks``).
    """

    field: ca.Function
    parameters: Vector
    watched: tuple[Watched, ...] = ()
    mortal: bool = False
    kinks: tuple[float, ...] = ()

    def outcome(self, fired: int) -> tuple[int | None, str]:
        """Tell a transition from a fall."""
        fell = self.mortal and fired == len(self.watched) - 1
        return (None, FELL) if fell else (fired, "")


def prepare(system: HybridSystem, name: str) -> Flow:
    """Prepare the flow through a domain of a system, in native code where that can be had."""
    domain = system.domain(name)
    watched = watched_functions(domain, system.leaving(name))
    return prepare_course(Course(domain.field, domain.parameters, watched, domain.alive is not None, domain.kinks))


def prepare_course(course: Course) -> Flow:
    """Prepare a flow from functions, in native code where that can be had."""
    from amble.simulation import interpreted, native

    flow = native.prepare(course)
    return interpreted.prepare(course) if flow is None else flow


def watched_functions(domain: Domain, leaving: tuple[Transition, ...]) -> tuple[Watched, ...]:
    """List the guards in the order of the transitions, then the margin of the domain where it has one."""
    guards = [Watched(transition.guard, transition.direction, transition.earliest) for transition in leaving]
    margin = [] if domain.alive is None else [Watched(domain.alive, -1, 0.0)]
    return (*guards, *margin)
