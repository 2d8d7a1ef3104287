"""Simulation of a hybrid system for a number of cycles, recorded with its signals."""

from __future__ import annotations

import time

import numpy as np

from amble.hybrid import HybridSystem
from amble.simulation.bound import bind
from amble.simulation.trace import Trace
from amble.simulation.walk import Progress, walk
from amble.types import IntegerVector, NodeValues, Vector


def simulate(
    system: HybridSystem,
    start: Vector,
    cycles: int,
    tolerance: float = 1e-8,
    samples: int = 21,
    time_limit: float = 10.0,
    progress: Progress | None = None,
    max_step: float | None = None,
) -> Trace:
    """Simulate a hybrid system from the entry of its first domain.

    A cycle is complete when the first domain is entered again. A motion that falls (the margin
    ``Domain.admissibility`` is not positive), that reaches no guard within ``time_limit``, whose events accumulate
    (Zeno), or that cannot go on (a rate that is not a number) ends the trace early: then ``Trace.ended`` says why, and
    no error is raised.

    Args:
        system: the system.
        start: state at the entry of the first domain, (n_x,).
        cycles: how many cycles, at least 1.
        tolerance: relative and absolute tolerance of the integrator, between 1e-13 and 1e-2.
        samples: recorded samples a domain, evenly spaced in time from its entry to its end, at least 2.
        time_limit: the longest that one domain may last, s.
        progress: called after every cycle.
        max_step: the longest time between two looks at the guards, s; a thousandth of ``time_limit`` by default. No
            excursion of a guard that lasts longer is missed; of a guard that is smooth on the scale of the looks
            shorter ones are found too, and with ``Transition.slope_bound`` all.

    Raises:
        InputError: for a start of another size or that is not finite, and for numbers outside their range.
    """
    began = time.perf_counter()
    solution = walk(system, start, cycles, tolerance, samples, time_limit, progress, max_step)
    lengths = [part.arc.clock.size for part in solution.arcs]
    clock = np.concatenate([part.arc.clock for part in solution.arcs])
    state = np.concatenate([part.arc.state for part in solution.arcs])
    domain = np.repeat([part.domain for part in solution.arcs], lengths)
    return Trace(
        domains=tuple(candidate.name for candidate in system.domains),
        state_names=system.state_names,
        time=clock + np.repeat([part.entered for part in solution.arcs], lengths),
        clock=clock,
        domain=domain,
        cycle=np.repeat([part.cycle for part in solution.arcs], lengths),
        state=state,
        signals=_signals(system, clock, state, domain),
        events=solution.events,
        cycles=solution.cycles,
        ended=solution.ended,
        tolerance=tolerance,
        seconds=time.perf_counter() - began,
    )


def _signals(system: HybridSystem, clock: Vector, state: NodeValues, domain: IntegerVector) -> dict[str, NodeValues]:
    """Evaluate the signals at all samples, a domain at a time; NaN where a domain does not declare a signal."""
    recorded: dict[str, NodeValues] = {}
    for position, candidate in enumerate(system.domains):
        rows = np.flatnonzero(domain == position)
        if candidate.signals is None or not rows.size:
            continue
        values = bind(candidate.signals, candidate.parameters).along(clock[rows], state[rows])
        for name, value in zip(candidate.signals.name_out(), values, strict=True):
            if name not in recorded:
                recorded[name] = np.full((clock.size, value.shape[1]), np.nan)
            recorded[name][rows] = value
    return recorded
