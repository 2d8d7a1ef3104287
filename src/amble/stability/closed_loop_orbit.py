"""The closed loop's own orbit of a gait, and reference curves that reproduce all of it.

The optimised motion solves the discretised problem; the closed loop's fixed point lies about 1e-5 away. Output weights
must not move the orbit, so the references of every coordinate, the base's orientation too, are fitted to the closed
loop's own orbit (docs/theory/virtual-constraints.md, section 7).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.control.outputs import selection_matrix
from amble.gait import Feedback, Gait
from amble.gait.closed_loop import REFERENCE_ORDER, closed_loop, start_state
from amble.hybrid import HybridSystem
from amble.numerics.bezier import fit
from amble.progress import Progress
from amble.simulation import simulate
from amble.stability.fixed_point import FixedPoint, fixed_point

FIT_SAMPLES = 101
FIT_TOLERANCE = 1e-12


def without_yaw(system: HybridSystem, mirrored: bool) -> HybridSystem:
    """Leave the turn about the vertical out of the symmetries of a mirrored half cycle.

    Of all turned copies of an orbit only the one along x repeats under the mirror; the fixed point must be that one,
    because weights on yaw refer to it.
    """
    kept = [symmetry for symmetry in system.symmetries if not (mirrored and symmetry.name == "yaw")]
    return HybridSystem(system.domains, system.transitions, tuple(kept), system.state_names)


def closed_loop_fixed_point(gait: Gait, progress: Progress | None = None) -> tuple[HybridSystem, FixedPoint]:
    """Return the closed loop of the solved stances of a gait and its fixed point nearest to the gait's start.

    Of a mirrored gait this is half a cycle, closed by the mirror: the multipliers of the full one are the squares.

    Args:
        gait: the gait.
        progress: called after every Newton step.

    Raises:
        FallError: the closed loop does not return from the gait's start.
        NotSolvedError: Newton does not converge.
    """
    system = without_yaw(closed_loop(gait, half=True), gait.pattern.mirrored)
    return system, fixed_point(system, start_state(gait), progress=progress)


def own_feedback(gait: Gait) -> Feedback:
    """Return the feedback at theta_0: references of the closed loop's own orbit, weights of the gait problem.

    Errors as in ``closed_loop_fixed_point``.
    """
    system, found = closed_loop_fixed_point(replace(gait, feedback=None))
    trace = simulate(system, found.state, 1, FIT_TOLERANCE, samples=FIT_SAMPLES)
    base, size = 3, gait.robot.size
    references, durations = {}, {}
    for index, stance in enumerate(gait.pattern.solved):
        here = trace.domain == index
        clock, state = trace.clock[here], trace.state[here]
        duration = float(clock[-1])
        rates = state[:, size + base :] * duration
        references[stance.name] = fit(state[:, base:size], rates, clock / duration, REFERENCE_ORDER)
        durations[stance.name] = duration
    weights = {
        stance.name: selection_matrix(gait.robot, gait.outputs.of(stance.name)) for stance in gait.pattern.solved
    }
    return Feedback(references, weights, durations, np.array(found.state))
