"""The closed loop of a gait, walked for many cycles."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from amble.control import AllocationLaw
from amble.control.motion_equations import SMALLEST_PIVOT
from amble.errors import WorkError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.hybrid import HybridSystem
from amble.simulation.perturbation import perturbed
from amble.simulation.simulate import simulate
from amble.simulation.trace import Trace
from amble.simulation.walk import Progress


def simulate_gait(
    gait: Gait,
    cycles: int,
    law: AllocationLaw | None = None,
    tolerance: float = 1e-8,
    perturbation: float = 0.0,
    seed: int = 0,
    progress: Progress | None = None,
    loop: Callable[[Gait, AllocationLaw | None], HybridSystem] | None = None,
) -> Trace:
    """Simulate the closed loop of a gait from its own start.

    Args:
        gait: the gait; with feedback its stabilised outputs are used.
        cycles: gait cycles to walk, at least 1.
        law: another allocation law than the gait's.
        tolerance: relative and absolute tolerance of the integrator.
        perturbation: change of every start state, up or down at random, in its own unit.
        seed: seed of the change.
        progress: called after every cycle with the cycles completed and the cycles wanted.
        loop: what closes the loop; by default ``gait.closed_loop.closed_loop``, else for example the exported C code.

    Returns:
        The trace; where the robot falls, ``Trace.ended`` says when and why, and the pivots whether rank was lost.

    Raises:
        WorkError: the decoupling equations lose rank although the motion goes on; the torques mean nothing there.
    """
    start = perturbed(start_state(gait), perturbation, seed)
    system = (loop or closed_loop)(gait, law)
    trace = simulate(system, start, cycles, tolerance, progress=progress)
    if trace.completed:
        _require_rank(trace)
    return trace


def _require_rank(trace: Trace) -> None:
    pivots = trace.signals["pivot"][:, 0]
    place = int(np.argmin(pivots))
    if not pivots[place] >= SMALLEST_PIVOT:
        raise WorkError(
            f"the decoupling equations lose rank in domain '{trace.domains[trace.domain[place]]}' at "
            f"{trace.time[place]:.6g} s: smallest pivot {pivots[place]:.2g}, at least {SMALLEST_PIVOT:g} is needed"
        )
