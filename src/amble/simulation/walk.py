"""The motion of a hybrid system: domain after domain, event after event, for a number of cycles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from amble.errors import InputError
from amble.hybrid import HybridSystem
from amble.io.registry import Lookup
from amble.progress import Progress, ProgressReport
from amble.simulation.ending import endless, explained
from amble.simulation.flow import LOOKS_IN_TIME_LIMIT, RESOLUTION, Arc, Flow
from amble.simulation.preparation import prepare
from amble.simulation.prepared import PreparedDomain, prepare_domain
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


def walk(
    system: HybridSystem,
    start: Vector,
    cycles: int,
    tolerance: float,
    samples: int,
    time_limit: float,
    progress: Progress | None = None,
    max_step: float | None = None,
    prepare: Callable[[HybridSystem, str], Flow] = prepare,
) -> HybridArc:
    """Move through the domains of a system; arguments and errors are those of ``simulate``.

    ``prepare`` gives the flow through a domain of a system by its name.
    """
    entry = np.array(start, dtype=np.float64).reshape(-1)
    longest = longest_look(time_limit, max_step)
    _check(system, entry, cycles, tolerance, samples)
    arcs: list[DomainArc] = []
    events: list[Event] = []
    ended = COMPLETED
    prepared: dict[str, tuple[PreparedDomain, Flow]] = {}
    stays: dict[str, list[float]] = {}
    current, clock, done, passed = system.domains[0].name, 0.0, 0, 0
    while done < cycles:
        if current not in prepared:
            prepared[current] = prepare_domain(system, current), prepare(system, current)
        here, flow = prepared[current]
        stopped = endless(stays.get(current, ()), passed)
        if stopped:
            ended = f"the motion {stopped} {_place(current, done, clock)}"
            break
        barrier = here.barred(entry)
        at_once = None if barrier else here.fired_at(entry)
        if barrier or at_once is not None:
            arc = _halted(entry, barrier, at_once)
        else:
            arc = flow(entry, tolerance, time_limit, samples, longest)
        arcs.append(DomainArc(here.number, done, clock, arc))
        clock += arc.clock[-1]
        if arc.fired is None:
            ended = f"the motion {explained(here, flow, entry, arc, _place(current, done, clock), time_limit)}"
            break
        if not any(transition.at_entry for transition in here.leaving):  # a stay between landings may be nothing
            stays.setdefault(current, []).append(float(arc.clock[-1]))
        passed += 1
        before = arc.state[-1]
        entry = here.reset(arc.fired, arc.clock[-1], before)
        transition = here.leaving[arc.fired]
        events.append(Event(clock, transition.name, frozen(before), frozen(entry)))
        current = transition.target
        if current == system.domains[0].name:
            done, passed = done + 1, 0
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
        max_step: float | None,
    ) -> HybridArc:
        """Move from the entry of the first domain for a number of cycles; arguments are those of ``simulate``."""


ENGINES: Lookup[Engine] = Lookup("engine")
"""The engines that ``simulate`` and the command line can name."""

ENGINES.register("native", walk)


def longest_look(time_limit: float, max_step: float | None) -> float:
    """Return the longest time between two looks at the guards, s.

    Raises:
        InputError: the time limit or the longest step is no positive time.
    """
    if not 0 < time_limit < np.inf:
        raise InputError(f"the time limit of a domain is a positive time, not {time_limit:g} s")
    if max_step is None:
        return time_limit / LOOKS_IN_TIME_LIMIT
    if not max_step >= RESOLUTION:
        raise InputError(f"max_step is a time of at least {RESOLUTION:g} s, not {max_step:g} s")
    return max_step


def _check(system: HybridSystem, start: Vector, cycles: int, tolerance: float, samples: int) -> None:
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


def _place(domain: str, cycle: int, clock: float) -> str:
    return f"in domain '{domain}' of cycle {cycle} at {clock:.6g} s"


def _halted(entry: Vector, ended: str, fired: int | None) -> Arc:
    """A motion that does not begin, or goes on to the next domain at once."""
    return Arc(np.zeros(1), entry[np.newaxis].copy(), fired, ended, 0)
