"""Simulating a gait: its closed loop, from its own start or beside it."""

from __future__ import annotations

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
    system: HybridSystem | None = None,
    progress: Progress | None = None,
) -> Trace:
    """Simulate the closed loop of a gait.

    Args:
        gait: the gait; with feedback its stabilised outputs are used.
        cycles: gait cycles to walk.
        law: another allocation law than the gait's.
        tolerance: relative and absolute tolerance of the integrator.
        perturbation: largest random change of every start state, in its own unit.
        seed: of the change.
        system: another closed loop of the same states than ``closed_loop(gait, law)``, such as the exported controller.
        progress: called after every cycle.

    Raises:
        InputError: for numbers outside their range; a fall is no error but ends the trace (``Trace.ended``).
    """
    start = perturbed(start_state(gait), perturbation, seed)
    return simulate(system or closed_loop(gait, law), start, cycles, tolerance, progress=progress)
