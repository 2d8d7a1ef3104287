"""The motion of a hybrid system: domain after domain, event after event, for a number of cycles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation.bound import Bound, bind
from amble.simulation.flow import FELL, STUCK, TOO_LONG, Flow, Passage, prepare
from amble.simulation.trace import COMPLETED, Event
from amble.types import Vector, frozen

Progress = Callable[[int, int], None]
"""Called after every cycle with the cycles completed and the cycles wanted."""

FEWEST_SAMPLES = 2
LOOSEST, TIGHTEST = 1e-2, 1e-13


@dataclass(frozen=True)
class Visit:
    """One stay in a domain: which, in which cycle, entered when (s), and the motion through it."""

    domain: int
    cycle: int
    entered: float
    passage: Passage


@dataclass(frozen=True)
class Walked:
    """A motion: its visits, the events between them, the cycles completed, and why it ended (see ``Trace.ended``)."""

    visits: tuple[Visit, ...]
    events: tuple[Event, ...]
    cycles: int
    ended: str


@dataclass(frozen=True)
class Stage:
    """A domain prepared for motions through it: its place in the system, its margin and the resets that leave it."""

    number: int
    domain: Domain
    leaving: tuple[Transition, ...]
    alive: Bound | None
    resets: tuple[Bound, ...]

    def barred(self, entry: Vector) -> str:
        """Say why a motion cannot begin here (``Passage.ended``); empty where it can."""
        if not np.all(np.isfinite(entry)):
            return STUCK
        if self.alive is not None and not self.alive(0.0, entry)[0][0] > 0:
            return FELL
        return ""

    def reset(self, fired: int, clock: float, state: Vector) -> Vector:
        """Return the state after the reset of a transition that leaves the domain, (n_x,)."""
        return self.resets[fired](clock, state)[0]


def prepare_stage(system: HybridSystem, name: str) -> Stage:
    """Prepare a domain of a system."""
    domain, leaving = system.domain(name), system.leaving(name)
    alive = None if domain.alive is None else bind(domain.alive, domain.parameters)
    resets = tuple(bind(transition.reset, domain.parameters) for transition in leaving)
    return Stage([candidate.name for candidate in system.domains].index(name), domain, leaving, alive, resets)


def walk(
    system: HybridSystem,
    start: Vector,
    cycles: int,
    tolerance: float,
    samples: int,
    longest: float,
    progress: Progress | None = None,
) -> Walked:
    """Move through the domains of a system; arguments and errors are those of ``simulate``."""
    entry = np.array(start, dtype=np.float64).reshape(-1)
    _check(system, entry, cycles, tolerance, samples, longest)
    visits: list[Visit] = []
    events: list[Event] = []
    ended = COMPLETED
    prepared: dict[str, tuple[Stage, Flow]] = {}
    current, clock, done = system.domains[0].name, 0.0, 0
    while done < cycles:
        if current not in prepared:
            prepared[current] = prepare_stage(system, current), prepare(system, current)
        stage, flow = prepared[current]
        barrier = stage.barred(entry)
        passage = _halted(entry, barrier) if barrier else flow(entry, tolerance, longest, samples)
        visits.append(Visit(stage.number, done, clock, passage))
        clock += passage.clock[-1]
        if passage.fired is None:
            ended = f"{_sentence(passage.ended)} in domain '{current}' of cycle {done} at {clock:.6g} s"
            break
        before = passage.state[-1]
        entry = stage.reset(passage.fired, passage.clock[-1], before)
        transition = stage.leaving[passage.fired]
        events.append(Event(clock, transition.name, frozen(before), frozen(entry)))
        current = transition.target
        if current == system.domains[0].name:
            done += 1
            if progress is not None:
                progress(done, cycles)
    return Walked(tuple(visits), tuple(events), done, ended)


def _check(system: HybridSystem, start: Vector, cycles: int, tolerance: float, samples: int, longest: float) -> None:
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
    if not 0 < longest < np.inf:
        raise InputError(f"the longest stay in a domain is a positive time, not {longest:g} s")


def _halted(entry: Vector, ended: str) -> Passage:
    """A motion that does not begin."""
    return Passage(np.zeros(1), entry[np.newaxis].copy(), None, ended, 0)


def _sentence(ended: str) -> str:
    if ended == TOO_LONG:
        return "the motion reached no guard within the longest time allowed"
    return f"the motion {ended}"
