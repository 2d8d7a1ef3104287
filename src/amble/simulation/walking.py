"""The closed loop of a gait, walked for many cycles."""

from __future__ import annotations

from collections.abc import Callable

from amble.control import AllocationLaw
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
        perturbation: largest random change of every start state, in its own unit.
        seed: seed of the change.
        progress: called after every cycle with the cycles completed and the cycles wanted.
        loop: what closes the loop; by default ``gait.closed_loop.closed_loop``, else for example the exported C code.

    Returns:
        The trace; where the robot falls, ``Trace.ended`` says when and why.
    """
    start = perturbed(start_state(gait), perturbation, seed)
    system = (loop or closed_loop)(gait, law)
    return simulate(system, start, cycles, tolerance, progress=progress)
