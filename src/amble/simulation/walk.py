"""The motion of a hybrid system: domain after domain, event after event, for a number of cycles."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from amble.amounts import check_amount
from amble.errors import InputError
from amble.hybrid import HybridSystem, Transition
from amble.io.registry import Lookup
from amble.progress import Progress, ProgressReport
from amble.simulation.flow import EVENT_SAMPLES_IN_TIME_LIMIT, RESOLUTION, TOO_LONG, Arc, Flow
from amble.simulation.prepared import PreparedDomain, prepare, prepare_domain
from amble.simulation.trace import COMPLETED, Event
from amble.types import Vector, frozen

MOST_EVENTS = 10000
"""Events of one cycle: a motion that never enters the first domain again has to end."""

TOO_MANY = f"has not entered the first domain again after {MOST_EVENTS} events"
ZENO = "has events that accumulate (Zeno): they follow each other faster than their clock can be told"

FEWEST_STAYS, MOST_STAYS = 5, 200
SHRINKING, SHRUNK = 0.9999, 0.6
"""Each stay is this share of the one before at most, and the last this share of the first of them."""

ACCUMULATED = 100.0 * RESOLUTION
"""A stay in a domain so short that its end is no longer located well, s."""

SHORTLY = 1e-6
"""After this share of the time limit it is seen where a guard goes from the entry."""

MOST_CYCLES, FEWEST_SAMPLES, MOST_SAMPLES = 1_000_000, 2, 100_000
MOST_NUMBERS = 50_000_000
"""States of a motion that are recorded, and kept in memory with their signals."""

SHORTEST_STEP = 1e-6
"""Of ``max_step``, as a share of the time limit: so often is a guard looked at in one domain at most."""

LOOSEST, TIGHTEST = 1e-2, 1e-13


def endless(stays: Sequence[float], passed: int) -> str:
    """Say why a motion with ever more events is not followed farther; empty where it is.

    Events accumulate where the last stays in a domain shrink, each against the one before, and the last is nothing. Of
    stays that are short and come to a limit above 0 the ratio goes to 1.

    Args:
        stays: durations of the stays in the present domain so far, in order, s.
        passed: events of the present cycle so far.
    """
    if passed >= MOST_EVENTS:
        return TOO_MANY
    latest = np.array(stays[-MOST_STAYS:])
    if latest.size < FEWEST_STAYS or latest[-1] >= ACCUMULATED:
        return ""
    shrinks = np.all(latest[1:] <= SHRINKING * latest[:-1]) and latest[-1] <= SHRUNK * latest[0]
    return ZENO if shrinks else ""


def explained(here: PreparedDomain, flow: Flow, entry: Vector, arc: Arc, place: str, time_limit: float) -> str:
    """Say why an arc ended without a transition, where, and what the user can do.

    Args:
        here: the domain.
        flow: through it.
        entry: state at its entry, (n,); of a flow that carries more than the state, all of it.
        arc: the arc.
        place: where it ended, in words.
        time_limit: the longest that a domain may last, s.
    """
    if arc.ended != TOO_LONG:
        return f"{arc.ended} {place}"
    limit = f"reached no guard within the time limit {place} (time_limit is {time_limit:g} s)"
    short = SHORTLY * time_limit
    later = flow(entry, 1e-10, short, 2, short).state[-1]
    passed = [_passed(here, transition, entry, later, short) for transition in here.leaving]
    return "; ".join([limit, *filter(None, passed)])


def _passed(here: PreparedDomain, transition: Transition, entry: Vector, later: Vector, short: float) -> str:
    """Say how a guard was already past zero at the entry; empty where it was not."""
    size = here.domain.state_size
    before, after = (
        transition.direction * float(transition.guard(clock, state[:size], here.domain.parameters))
        for clock, state in ((0.0, entry), (short, later))
    )
    if not after > max(before, 0.0) or transition.dead_time > 0.0:
        return ""
    if abs(before) <= 1e-3 * (after - before):
        return (
            f"the guard of '{transition.name}' is zero at the entry and passes it at once: where the fields of both "
            "sides point at it the motion slides along it, for which there is no domain"
        )
    if before > 0.0:
        return f"the guard of '{transition.name}' was past zero at the entry and moved away"
    return ""


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
    prepared: dict[str, tuple[PreparedDomain, Flow]] | None = None,
) -> HybridArc:
    """Move through the domains of a system; arguments and errors are those of ``simulate``.

    ``prepare`` gives the flow through a domain of a system by its name. What was prepared is kept in ``prepared``, for
    further walks of the same system in the same thread.
    """
    entry = np.array(start, dtype=np.float64).reshape(-1)
    longest = longest_step(time_limit, max_step)
    _check(system, entry, tolerance)
    check_record(cycles, samples, len(system.domains), system.state_size)
    arcs: list[DomainArc] = []
    events: list[Event] = []
    ended = COMPLETED
    prepared = {} if prepared is None else prepared
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


def longest_step(time_limit: float, max_step: float | None) -> float:
    """Return the longest time between two event samples, s.

    Raises:
        InputError: the time limit or the longest step is no positive time.
    """
    if not 0 < time_limit < np.inf:
        raise InputError(f"the time limit of a domain is a positive time, not {time_limit:g} s")
    if max_step is None:
        return time_limit / EVENT_SAMPLES_IN_TIME_LIMIT
    shortest = max(RESOLUTION, SHORTEST_STEP * time_limit)
    if not max_step >= RESOLUTION:
        raise InputError(f"max_step is a time of at least {RESOLUTION:g} s, not {max_step:g} s")
    if max_step < shortest:
        raise InputError(
            f"max_step is at least a millionth of the time limit ({time_limit:g} s), {shortest:g} s, not {max_step:g} s"
        )
    return max_step


def check_record(cycles: int, samples: int, domains: int, states: int) -> None:
    """Refuse a motion that is too long to be recorded.

    Args:
        cycles: how many.
        samples: of a domain.
        domains: of a cycle.
        states: of a sample.

    Raises:
        InputError: in one sentence.
    """
    check_amount("cycles", cycles, 1, MOST_CYCLES)
    check_amount("samples a domain", samples, FEWEST_SAMPLES, MOST_SAMPLES)
    numbers = cycles * samples * domains * states
    if numbers > MOST_NUMBERS:
        raise InputError(
            f"{cycles:,} cycles of {domains} domains, {samples:,} samples of {states} states each, are {numbers:.2g} "
            f"numbers; {MOST_NUMBERS:.2g} are recorded at most: ask for fewer cycles (up to "
            f"{MOST_NUMBERS // (samples * domains * states):,}) or samples"
        )


def _check(system: HybridSystem, start: Vector, tolerance: float) -> None:
    if start.size != system.state_size:
        raise InputError(f"the start has {start.size} values, not {system.state_size}")
    if not np.all(np.isfinite(start)):
        raise InputError("the start of the simulation is not finite")
    check_tolerance(tolerance)


def check_tolerance(tolerance: float) -> None:
    """Refuse a tolerance at which nothing can be integrated, or nothing believed.

    Raises:
        InputError: in one sentence.
    """
    if not TIGHTEST <= tolerance <= LOOSEST:
        raise InputError(f"the tolerance {tolerance:g} is not between {TIGHTEST:g} and {LOOSEST:g}")


def _place(domain: str, cycle: int, clock: float) -> str:
    return f"in domain '{domain}' of cycle {cycle} at {clock:.6g} s"


def _halted(entry: Vector, ended: str, fired: int | None) -> Arc:
    """A motion that does not begin, or goes on to the next domain at once."""
    return Arc(np.zeros(1), entry[np.newaxis].copy(), fired, ended, 0)
