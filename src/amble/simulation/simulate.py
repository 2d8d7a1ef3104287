"""Simulation of a hybrid system: domain after domain, event after event, for a number of cycles."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.hybrid.system import numeric
from amble.simulation.flow import FELL, NOT_FINITE, TOO_LONG, Flow, Passage, prepare
from amble.simulation.trace import Event, Trace
from amble.types import NodeValues, Vector, frozen

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


def simulate(
    system: HybridSystem,
    start: Vector,
    cycles: int,
    tolerance: float = 1e-8,
    samples: int = 21,
    longest: float = 10.0,
    progress: Progress | None = None,
) -> Trace:
    """Simulate a hybrid system from the entry of its first domain.

    A cycle is complete when the first domain is entered again. A motion that falls (the margin ``Domain.alive`` is not
    positive), that reaches no guard within ``longest``, or that is not finite any more ends the trace early: then
    ``Trace.ended`` says why, and no error is raised.

    Args:
        system: the system.
        start: state at the entry of the first domain, (n_x,).
        cycles: how many cycles, at least 1.
        tolerance: relative and absolute tolerance of the integrator, between 1e-13 and 1e-2.
        samples: recorded samples a domain, evenly spaced in time from its entry to its end, at least 2.
        longest: the longest that one domain may last, s.
        progress: called after every cycle.

    Raises:
        InputError: for a start of another size or that is not finite, and for numbers outside their range.
    """
    began = time.perf_counter()
    entry = np.array(start, dtype=np.float64).reshape(-1)
    _check(system, entry, cycles, tolerance, samples, longest)
    visits: list[Visit] = []
    events: list[Event] = []
    ended = "completed"
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
    return _trace(system, visits, tuple(events), done, ended, tolerance, began)


def apply_reset(domain: Domain, transition: Transition, clock: float, state: Vector) -> Vector:
    """Return the state after the reset of a transition that leaves ``domain``, (n_x,)."""
    return numeric(transition.reset(clock, state, domain.parameters))


def _check(
    system: HybridSystem, start: Vector, cycles: int, tolerance: float, samples: int, longest: float
) -> None:
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


def _through(
    flow: Flow, domain: Domain, entry: Vector, tolerance: float, longest: float, samples: int
) -> Passage:
    """Pass through a domain; a motion that is not alive at its entry does not begin."""
    stopped = ""
    if not np.all(np.isfinite(entry)):
        stopped = NOT_FINITE
    elif domain.alive is not None and not float(domain.alive(0.0, entry, domain.parameters)) > 0:
        stopped = FELL
    if stopped:
        return Passage(np.zeros(1), entry[np.newaxis].copy(), None, stopped, 0)
    return flow(entry, tolerance, longest, samples)


def _sentence(ended: str) -> str:
    if ended == TOO_LONG:
        return "the motion reached no guard within the longest time allowed"
    return f"the motion {ended}"


def _trace(
    system: HybridSystem,
    visits: list[Visit],
    events: tuple[Event, ...],
    done: int,
    ended: str,
    tolerance: float,
    began: float,
) -> Trace:
    lengths = [visit.passage.clock.size for visit in visits]
    clock = np.concatenate([visit.passage.clock for visit in visits])
    state = np.concatenate([visit.passage.state for visit in visits])
    domain = np.repeat([visit.domain for visit in visits], lengths)
    return Trace(
        domains=tuple(candidate.name for candidate in system.domains),
        state_names=system.state_names,
        time=clock + np.repeat([visit.entered for visit in visits], lengths),
        clock=clock,
        domain=domain,
        cycle=np.repeat([visit.cycle for visit in visits], lengths),
        state=state,
        signals=_signals(system, clock, state, domain),
        events=events,
        cycles=done,
        ended=ended,
        tolerance=tolerance,
        seconds=time.perf_counter() - began,
    )


def _signals(system: HybridSystem, clock: Vector, state: NodeValues, domain: Vector) -> dict[str, NodeValues]:
    """Evaluate the signals at all samples, a domain at a time; NaN where a domain does not declare a signal."""
    recorded: dict[str, NodeValues] = {}
    for position, candidate in enumerate(system.domains):
        rows = np.flatnonzero(domain == position)
        if candidate.signals is None or not rows.size:
            continue
        values = evaluate_many(candidate.signals, clock[rows], state[rows], candidate.parameters)
        for name, value in values.items():
            if name not in recorded:
                recorded[name] = np.full((clock.size, value.shape[1]), np.nan)
            recorded[name][rows] = value
    return recorded


def evaluate_many(function: ca.Function, clock: Vector, state: NodeValues, parameters: Vector) -> dict[str, NodeValues]:
    """Evaluate a function (t, x, p) at many samples; returns output name -> (n, width)."""
    count = clock.size
    mapped = function.map(count)
    repeated = np.tile(parameters[:, np.newaxis], (1, count))
    results = mapped(clock[np.newaxis], state.T, repeated)
    outputs = [results] if function.n_out() == 1 else results
    return {name: np.asarray(value).T for name, value in zip(function.name_out(), map(ca.DM.full, outputs), strict=True)}
