"""Simulation of a gait or of any hybrid system for a number of cycles, recorded with its signals."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import overload

import numpy as np

from amble.control import AllocationLaw
from amble.control.motion_equations import SMALLEST_PIVOT
from amble.defaults import CYCLES, ENGINE, TOLERANCE
from amble.errors import InputError, WorkError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.control_law import ControlLaw
from amble.gait.unilateral_loop import unilateral_loop
from amble.gait.unilateral_state import unilateral_start
from amble.hybrid import HybridSystem
from amble.progress import Progress
from amble.simulation.bound import bind
from amble.simulation.trace import Trace
from amble.simulation.walk import ENGINES, Engine
from amble.simulation.world_axes import in_world_axes
from amble.types import IntegerVector, NodeValues, Vector, frozen

Loop = Callable[[Gait, AllocationLaw | None], HybridSystem]
"""What closes the loop of a gait."""

SAMPLES, TIME_LIMIT = 21, 10.0


@overload
def simulate(
    subject: Gait,
    start: Vector | None = None,
    cycles: int = CYCLES,
    tolerance: float = TOLERANCE,
    samples: int = SAMPLES,
    time_limit: float = TIME_LIMIT,
    *,
    perturbation: float = 0.0,
    seed: int = 0,
    engine: str = ENGINE,
    law: AllocationLaw | None = None,
    control: ControlLaw | None = None,
    loop: Loop | None = None,
    unilateral: bool = False,
    progress: Progress | None = None,
    max_step: float | None = None,
) -> Trace: ...


@overload
def simulate(
    subject: HybridSystem,
    start: Vector,
    cycles: int = CYCLES,
    tolerance: float = TOLERANCE,
    samples: int = SAMPLES,
    time_limit: float = TIME_LIMIT,
    *,
    perturbation: float = 0.0,
    seed: int = 0,
    engine: str = ENGINE,
    progress: Progress | None = None,
    max_step: float | None = None,
) -> Trace: ...


def simulate(
    subject: Gait | HybridSystem,
    start: Vector | None = None,
    cycles: int = CYCLES,
    tolerance: float = TOLERANCE,
    samples: int = SAMPLES,
    time_limit: float = TIME_LIMIT,
    *,
    perturbation: float = 0.0,
    seed: int = 0,
    engine: str = ENGINE,
    law: AllocationLaw | None = None,
    control: ControlLaw | None = None,
    loop: Loop | None = None,
    unilateral: bool = False,
    progress: Progress | None = None,
    max_step: float | None = None,
) -> Trace:
    """Simulate the closed loop of a gait, or a hybrid system, from the entry of its first domain.

    A cycle is complete when the first domain is entered again. A motion that falls (the margin
    ``Domain.admissibility`` is not positive), that reaches no guard within ``time_limit``, whose events accumulate
    (Zeno), or that cannot go on (a rate that is not a number) ends the trace early: then ``Trace.ended`` says why, and
    no error is raised.

    Args:
        subject: a gait, whose stabilised outputs are used where it has them; or a system.
        start: state at the entry of the first domain, (n_x,); a gait has its own, and one that turns heads along x.
        cycles: how many cycles, at least 1; with domains, samples and states at most 50 million numbers are recorded.
        tolerance: relative and absolute tolerance of the integrator, between 1e-13 and 1e-2.
        samples: recorded samples a domain, evenly spaced in time from its entry to its end, at least 2.
        time_limit: the longest that one domain may last, s.
        perturbation: change of every start state, up or down at random, in its own unit.
        seed: seed of the change.
        engine: name of what moves the system, see ``ENGINES``.
        law: of a gait, another allocation law than its own.
        control: of a gait, another feedback law than its own.
        loop: of a gait, what closes its loop; by default ``amble.closed_loop``, else such as ``amble.exported_loop``.
        unilateral: of a gait, on ground that pushes only (``amble.gait.unilateral_loop``): a foot that pulls is
            released, and one that leaves its friction cone ends the motion.
        progress: called after every cycle.
        max_step: the longest time between two event samples, s; a thousandth of ``time_limit`` by default, a millionth
            at least. No longer excursion of a guard is missed, of a guard that is smooth on the scale of the samples
            no shorter one either, and with ``Transition.slope_bound`` none.

    Raises:
        UnknownNameError: there is no engine of that name.
        InputError: a system without a start or with a law, a start of another size or that is not finite, numbers
            outside their range.
        WorkError: the decoupling equations of a gait lose rank although the motion goes on; the torques mean nothing
            there.
    """
    system, begin = _posed(subject, start, law, control, loop, unilateral)
    begin = perturbed(np.asarray(begin, dtype=np.float64).reshape(-1), perturbation, seed)
    if isinstance(subject, Gait) and unilateral:
        begin = unilateral_start(subject, begin)
    trace = _recorded(ENGINES[engine], system, begin, cycles, tolerance, samples, time_limit, progress, max_step)
    return _of_gait(subject, trace) if isinstance(subject, Gait) else trace


def _posed(
    subject: Gait | HybridSystem,
    start: Vector | None,
    law: AllocationLaw | None,
    control: ControlLaw | None,
    loop: Loop | None,
    unilateral: bool,
) -> tuple[HybridSystem, Vector]:
    """The system that is simulated, and from where: coordinates and rates of a gait."""
    if isinstance(subject, Gait):
        begin = start_state(subject) if start is None else start
        if loop is not None and (control is not None or unilateral):
            raise InputError("a loop of one's own has its own control law and its own contacts")
        if loop is not None:
            return loop(subject, law), begin
        return (unilateral_loop if unilateral else closed_loop)(subject, law, control=control), begin
    if start is None:
        raise InputError("a hybrid system is simulated from a start; only a gait has one of its own")
    if law is not None or loop is not None or control is not None or unilateral:
        raise InputError("only a gait takes another allocation law, control law, closed loop or unilateral contact")
    return subject, start


def _recorded(
    move: Engine,
    system: HybridSystem,
    start: Vector,
    cycles: int,
    tolerance: float,
    samples: int,
    time_limit: float,
    progress: Progress | None,
    max_step: float | None,
) -> Trace:
    began = time.perf_counter()
    solution = move(system, start, cycles, tolerance, samples, time_limit, progress, max_step)
    lengths = [part.arc.clock.size for part in solution.arcs]
    clock = np.concatenate([part.arc.clock for part in solution.arcs])
    state = np.concatenate([part.arc.state for part in solution.arcs])
    domain = np.repeat([part.domain for part in solution.arcs], lengths)
    return Trace(
        domains=tuple(candidate.name for candidate in system.domains),
        state_names=tuple(system.state_names),
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


def _of_gait(gait: Gait, trace: Trace) -> Trace:
    if trace.completed:
        _require_rank(trace)
    return in_world_axes(gait, trace)


def _require_rank(trace: Trace) -> None:
    pivots = trace.signals["pivot"][:, 0]
    place = int(np.argmin(pivots))
    if not pivots[place] >= SMALLEST_PIVOT:
        raise WorkError(
            f"the decoupling equations lose rank in domain '{trace.domains[trace.domain[place]]}' at "
            f"{trace.time[place]:.6g} s: smallest pivot {pivots[place]:.2g}, at least {SMALLEST_PIVOT:g} is needed"
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


LARGEST_PERTURBATION = 1e6
"""Of a state: far beyond any that a walk comes back from."""


def perturbed(state: Vector, size: float, seed: int) -> Vector:
    """Change every state by exactly size, up or down at random, in the state's own unit.

    Args:
        state: (n_x,).
        size: of every change, at least 0; with 0 the state itself is returned.
        seed: of the random numbers, at least 0; the same seed gives the same start.

    Raises:
        InputError: the size is negative or not finite, or the seed is negative.
    """
    if seed < 0:
        raise InputError(f"the seed of a perturbation is a whole number from 0 on, not {seed}")
    if not 0.0 <= size <= LARGEST_PERTURBATION:
        raise InputError(f"the size of a perturbation is a number from 0 to {LARGEST_PERTURBATION:g}, not {size}")
    sign = np.random.default_rng(seed).choice([-1.0, 1.0], len(state))
    return frozen(np.asarray(state) + size * sign)
