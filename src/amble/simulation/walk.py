"""The motion of a hybrid system: domain after domain, event after event, for a number of cycles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.io.registry import Lookup
from amble.progress import Progress, ProgressReport
from amble.simulation.bound import Bound, bind
from amble.simulation.flow import LEFT_DOMAIN, STUCK, TOO_LONG, Arc, Flow, prepare
from amble.simulation.trace import COMPLETED, Event
from amble.types import Vector, frozen

FEWEST_SAMPLES = 2
LOOSEST, TIGHTEST = 1e-2, 1e-13


@dataclass(frozen=True)
class DomainArc:
    """One stay in a domain: which, in which cycle, entered when (s), and the motion through it."""

    domain: int
    cycle: int
    entered: float
    arc: Arc


@dataclass(frozen=True)
class HybridArc:
    """A motion: its arcs, the events between them, the cycles completed, and why it ended (see ``Trace.ended``)."""

    arcs: tuple[DomainArc, ...]
    events: tuple[Event, ...]
    cycles: int
    ended: str


@dataclass(frozen=True)
class PreparedDomain:
    """A domain prepared for motions through it: its place in the system, its margin and the resets that leave it."""

    number: int
    domain: Domain
    leaving: tuple[Transition, ...]
    admissibility: Bound | None
    resets: tuple[Bound, ...]

    def barred(self, entry: Vector) -> str:
        """Say why a motion cannot begin here (``Arc.ended``); empty where it can."""
        if not np.all(np.isfinite(entry)):
            return STUCK
        if self.admissibility is not None and not self.admissibility(0.0, entry)[0][0] > 0:
            return LEFT_DOMAIN
        return ""

    def reset(self, fired: int, clock: float, state: Vector) -> Vector:
        """Return the state after the reset of a transition that leaves the domain, (n_x,)."""
        return self.resets[fired](clock, state)[0]


def prepare_domain(system: HybridSystem, name: str) -> PreparedDomain:
    """Prepare a domain of a system."""
    domain, leaving = system.domain(name), system.leaving(name)
    admissibility = None if domain.admissibility is None else bind(domain.admissibility, domain.parameters)
    resets = tuple(bind(transition.reset, domain.parameters) for transition in leaving)
    return PreparedDomain(
        [candidate.name for candidate in system.domains].index(name), domain, leaving, admissibility, resets
    )


def walk(
    system: HybridSystem,
    start: Vector,
    cycles: int,
    tolerance: float,
    samples: int,
    time_limit: float,
    progress: Progress | None = None,
    prepare: Callable[[HybridSystem, str], Flow] = prepare,
) -> HybridArc:
    """Move through the domains of a system; arguments and errors are those of ``simulate``.

    ``prepare`` gives the flow through a domain of a system by its name.
    """
    entry = np.array(start, dtype=np.float64).reshape(-1)
    _check(system, entry, cycles, tolerance, samples, time_limit)
    arcs: list[DomainArc] = []
    events: list[Event] = []
    ended = COMPLETED
    prepared: dict[str, tuple[PreparedDomain, Flow]] = {}
    current, clock, done = system.domains[0].name, 0.0, 0
    while done < cycles:
        if current not in prepared:
            prepared[current] = prepare_domain(system, current), prepare(system, current)
        here, flow = prepared[current]
        barrier = here.barred(entry)
        arc = _halted(entry, barrier) if barrier else flow(entry, tolerance, time_limit, samples)
        arcs.append(DomainArc(here.number, done, clock, arc))
        clock += arc.clock[-1]
        if arc.fired is None:
            ended = f"{_sentence(arc.ended)} in domain '{current}' of cycle {done} at {clock:.6g} s"
            break
        before = arc.state[-1]
        entry = here.reset(arc.fired, arc.clock[-1], before)
        transition = here.leaving[arc.fired]
        events.append(Event(clock, transition.name, frozen(before), frozen(entry)))
        current = transition.target
        if current == system.domains[0].name:
            done += 1
            if progress is not None:
                progress(ProgressReport(what="cycle", done=done, of=cycles))
    return HybridArc(tuple(arcs), tuple(events), done, ended)


class Engine(Protocol):
    """What moves a hybrid system; a function such as ``walk``."""

    def __call__(
        self,
        system: HybridSystem,
        start: Vector,
        cycles: int,
        tolerance: float,
        samples: int,
        time_limit: float,
        progress: Progress | None,
    ) -> HybridArc:
        """Move from the entry of the first domain for a number of cycles; arguments are those of ``simulate``."""


ENGINES: Lookup[Engine] = Lookup("engine")
"""The engines that ``simulate`` and the command line can name."""

ENGINES.register("native", walk)


def _check(system: HybridSystem, start: Vector, cycles: int, tolerance: float, samples: int, time_limit: float) -> None:
    if start.size != system.state_size:
        raise InputError(f"the start has {start.size} values, not {system.state_size}")
    if not np.all(np.isfinite(start)):
        raise InputError("the start of the simulation is not finite")
    if cycles < 1:
        raise InputError(f"a simulation takes at least 1 cycle, not {cycles}")
    if not TIGHTEST <= tolerance <= LOOSEST:
        raise InputError(f"the tolerance {tolerance:g} is not between {TIGHTEST:g} and {LOOSEST:g}")
    if samples < FEWEST_SAMPLES:
        raise InputError(f"a domain is recorded with at least {FEWEST_SAMPLES} samples, not {samples}")
    if not 0 < time_limit < np.inf:
        raise InputError(f"the time limit of a domain is a positive time, not {time_limit:g} s")


def _halted(entry: Vector, ended: str) -> Arc:
    """A motion that does not begin."""
    return Arc(np.zeros(1), entry[np.newaxis].copy(), None, ended, 0)


def _sentence(ended: str) -> str:
    if ended == TOO_LONG:
        return "the motion reached no guard within the time limit"
    return f"the motion {ended}"
