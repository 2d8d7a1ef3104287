"""The motion of a hybrid system: domain after domain, event after event, for a number of cycles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.hybrid.system import numeric
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
    flows: dict[str, Flow] = {}
    current, clock, done = system.domains[0], 0.0, 0
    order = {domain.name: position for position, domain in enumerate(system.domains)}
    while done < cycles:
        if current.name not in flows:
            flows[current.name] = prepare(system, current.name)
        passage = _through(flows[current.name], current, entry, tolerance, longest, samples)
        visits.append(Visit(order[current.name], done, clock, passage))
        clock += passage.clock[-1]
        if passage.fired is None:
            ended = f"{_sentence(passage.ended)} in domain '{current.name}' of cycle {done} at {clock:.6g} s"
            break
        transition = system.leaving(current.name)[passage.fired]
        before = passage.state[-1]
        entry = apply_reset(current, transition, passage.clock[-1], before)
        events.append(Event(clock, transition.name, frozen(before), frozen(entry)))
        current = system.domain(transition.target)
        if order[current.name] == 0:
            done += 1
            if progress is not None:
                progress(done, cycles)
    return Walked(tuple(visits), tuple(events), done, ended)


def apply_reset(domain: Domain, transition: Transition, clock: float, state: Vector) -> Vector:
    """Return the state after the reset of a transition that leaves ``domain``, (n_x,)."""
    return numeric(transition.reset(clock, state, domain.parameters))


def barred(domain: Domain, entry: Vector) -> str:
    """Say why a motion cannot begin in a domain (``Passage.ended``); empty where it can."""
    if not np.all(np.isfinite(entry)):
        return STUCK
    if domain.alive is not None and not float(domain.alive(0.0, entry, domain.parameters)) > 0:
        return FELL
    return ""


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


def _through(flow: Flow, domain: Domain, entry: Vector, tolerance: float, longest: float, samples: int) -> Passage:
    """Pass through a domain; a motion that is not alive at its entry does not begin."""
    stopped = barred(domain, entry)
    if stopped:
        return Passage(np.zeros(1), entry[np.newaxis].copy(), None, stopped, 0)
    return flow(entry, tolerance, longest, samples)


def _sentence(ended: str) -> str:
    if ended == TOO_LONG:
        return "the motion reached no guard within the longest time allowed"
    return f"the motion {ended}"
