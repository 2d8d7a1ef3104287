"""The Poincare map of a hybrid system: from the entry of its first domain to the next entry of its first domain.

The state after a reset lies on the section by itself, so the map needs no coordinates of a section: it takes any state
near an orbit, in all n coordinates, and returns a state just after a reset. Its derivative has the multipliers of the
orbit as eigenvalues, and one 0 more where the usual map on a section of dimension n - 1 has none.
"""

from __future__ import annotations

from amble.errors import FallError
from amble.hybrid import HybridSystem
from amble.simulation.walk import walk
from amble.types import Vector

TOLERANCE = 1e-12
TIME_LIMIT = 10.0


def poincare_map(
    system: HybridSystem,
    state: Vector,
    tolerance: float = TOLERANCE,
    time_limit: float = TIME_LIMIT,
    cycles: int = 1,
    max_step: float | None = None,
) -> Vector:
    """Map the entry state of the first domain to the next one, one cycle later, or several.

    Args:
        system: the system.
        state: at the entry of the first domain, (n_x,).
        tolerance: of the integrator, relative and absolute.
        time_limit: the longest that one domain may last, s.
        cycles: how often the map is applied.
        max_step: the longest time between two looks at the guards, s (``simulate``).

    Returns:
        The state at the entry of the first domain then, (n_x,).

    Raises:
        FallError: where the motion does not come back; the message says why and when.
        InputError: for a state of another size or that is not finite.
    """
    solution = walk(system, state, cycles, tolerance, 2, time_limit, max_step=max_step)
    if solution.cycles < cycles:
        raise FallError(solution.ended)
    return solution.events[-1].after
