"""The closed loop's own orbit of a gait, and reference curves that reproduce all of it.

The optimised motion solves the discretised problem; the closed loop's fixed point lies about 1e-5 away. Output weights
must not move the orbit, so the references of every coordinate, the base's orientation too, are fitted to the closed
loop's own orbit (docs/theory/virtual-constraints.md, section 7).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.control import AllocationLaw
from amble.control.outputs import selection_matrix
from amble.control.phase import DomainPhase
from amble.errors import NotSolvedError, WorkError
from amble.gait import Feedback, Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.gait.constraints import REFERENCE_ORDER
from amble.hybrid import HybridSystem
from amble.numerics.bezier import fit
from amble.progress import Progress
from amble.simulation import Trace, simulate
from amble.stability.fixed_point import FixedPoint, fixed_point
from amble.stability.landing_orders import orders_of
from amble.types import frozen

FIT_SAMPLES = 101
FIT_TOLERANCE = 1e-12

ENOUGH = 1e-9
"""Residual at which a fixed point is one where Newton comes to no smaller one; a certificate asks for 1e-8. Solo12's
pronk has multipliers of 0.99999 under the outputs of its problem, and Newton ended at 5e-10."""


def without_yaw(system: HybridSystem, mirrored: bool) -> HybridSystem:
    """Leave the turn about the vertical out of the symmetries of a mirrored half cycle.

    Of all turned copies of an orbit only the one along x repeats under the mirror; the fixed point must be that one,
    because weights on yaw refer to it.
    """
    kept = [symmetry for symmetry in system.symmetries if not (mirrored and symmetry.name == "yaw")]
    return HybridSystem(system.domains, system.transitions, tuple(kept), system.state_names)


def closed_loop_fixed_point(
    gait: Gait, progress: Progress | None = None, law: AllocationLaw | None = None, one_order: bool = False
) -> tuple[HybridSystem, FixedPoint]:
    """Return the closed loop of the solved stances of a gait and its fixed point nearest to the gait's start.

    Of a mirrored gait this is half a cycle, closed by the mirror: the multipliers of the full one are the squares.

    Where feet land one by one the map has a kink where all land at once. Newton's steps jump across it, while the map
    of one order of landing is smooth: its fixed point is the closed loop's where the feet land in that order. They may
    do so at the fixed point of no order: beside an unstable gait, of which a mesh leaves a small residual, the kinked
    map need not have one. It has one where one quadratic function falls in all orders, which makes it a contraction,
    if that holds in a neighbourhood that is large against the residual.

    Args:
        gait: the gait.
        progress: called after every Newton step.
        law: another allocation law than the gait's.
        one_order: where there is none, return the map of one order and its fixed point instead.

    Raises:
        FallError: the closed loop does not return from the gait's start.
        NotSolvedError: Newton does not converge.
    """
    system = without_yaw(closed_loop(gait, law, half=True), gait.pattern.mirrored)
    try:
        return system, fixed_point(system, start_state(gait), progress=progress, enough=ENOUGH)
    except NotSolvedError:
        beside = _in_one_order(gait, progress, law)
        for _, near in beside:
            try:
                return system, fixed_point(system, near.state)
            except WorkError:
                continue
        if beside and one_order:
            return beside[0]
        raise


def _in_one_order(
    gait: Gait, progress: Progress | None, law: AllocationLaw | None
) -> list[tuple[HybridSystem, FixedPoint]]:
    """Find the fixed points of the smooth maps of all orders of landing; of those that have one."""
    found = []
    for order in orders_of(gait):
        smooth = without_yaw(closed_loop(gait, law, half=True, orders=order), gait.pattern.mirrored)
        try:
            found.append((smooth, fixed_point(smooth, start_state(gait), progress=progress)))
        except WorkError:
            continue
    return found


_latest: list[tuple[Gait, HybridSystem, FixedPoint]] = []


def bare_fixed_point(gait: Gait, progress: Progress | None = None) -> tuple[HybridSystem, FixedPoint]:
    """Return the closed loop and its fixed point under the outputs of the gait problem, feedback left out.

    That of the latest gait is kept: who has looked whether its orbit is the recorded one stabilises it next, and where
    feet land one by one an unstable gait's fixed point takes a minute. Arguments and errors are those of
    ``closed_loop_fixed_point``, with one order of landing where the orbit needs it.
    """
    for known, system, point in _latest:
        if known is gait:
            return system, point
    system, point = closed_loop_fixed_point(replace(gait, feedback=None, control=None), progress, one_order=True)
    _latest[:] = [(gait, system, point)]
    return system, point


def own_feedback(gait: Gait) -> Feedback:
    """Return the feedback at theta_0: references of the closed loop's own orbit, weights of the gait problem.

    Errors as in ``closed_loop_fixed_point``; InputError where the phase does not grow all along the orbit.
    """
    system, found = bare_fixed_point(gait)
    trace = simulate(system, found.state, 1, FIT_TOLERANCE, samples=FIT_SAMPLES)
    return feedback_on(gait, trace)


def feedback_on(gait: Gait, orbit: Trace) -> Feedback:
    """Fit references over the gait's phase to one cycle of the solved stances; the weights are the gait problem's.

    Args:
        gait: the gait; only its robot, pattern and outputs matter.
        orbit: the motion, from the entry of the first domain, ``FIT_SAMPLES`` or as many samples a domain.

    Raises:
        InputError: the phase does not grow all along the motion.
    """
    base, size = len(gait.robot.base.axes), gait.robot.size
    references, weights, durations, numbers = {}, {}, {}, {}
    for index, stance in enumerate(gait.pattern.solved):
        name, here = stance.name, orbit.domain == index
        clock, state = orbit.clock[here], orbit.state[here]
        domain = DomainPhase(phase=gait.outputs.phase, robot=gait.robot, stance=stance)
        durations[name] = duration = float(clock[-1])
        numbers[name] = frozen(domain.measured(state[0, :size], state[-1, :size]))
        phase, pace = domain.along(clock, duration, state[:, :size], state[:, size:], numbers[name])
        rates = state[:, size + base :] / pace[:, None]
        references[name] = fit(state[:, base:size], rates, phase, REFERENCE_ORDER)
        weights[name] = selection_matrix(gait.robot, gait.outputs.of(name))
    return Feedback(
        references=references,
        weights=weights,
        durations=durations,
        start=np.array(orbit.state[0]),
        phase_numbers=numbers if gait.outputs.phase.numbers else {},
    )
