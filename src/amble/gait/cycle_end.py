"""What closes a cycle of a gait's closed loop: the mirror of a mirrored half, or the turn of a gait that turns.

A gait with a yaw rate is periodic modulo its turn psi about the vertical: the state at the end of a cycle, turned back
by psi, is that at its entry. Outputs and references see the turned state, so the law does not depend on the heading
that earlier cycles led to (docs/theory/stability.md, section 5).
"""

from __future__ import annotations

from collections.abc import Callable

import casadi as ca

from amble.control.stance_functions import ARGUMENTS
from amble.gait.landing_stances import landing_steps
from amble.gait.record import Gait
from amble.robot.turn import turned_state

StateMap = Callable[[ca.MX], ca.MX]
"""What a state passes."""


def closing(gait: Gait) -> StateMap | None:
    """Return what the state passes at the end of the solved stances; nothing for a straight gait without a mirror."""
    if gait.pattern.mirrored:
        return gait.robot.mirror.state
    if gait.turn == 0.0:
        return None
    x = ca.SX.sym("x", 2 * gait.robot.size)
    return ca.Function("turned_back", [x], [turned_state(x, -gait.turn)], ["x"], ["state"])


def closed_reset(reset: ca.Function, passed: StateMap) -> ca.Function:
    """Return a reset whose result passes something."""
    t, x, p = (ca.MX.sym(name, reset.numel_in(i)) for i, name in enumerate(ARGUMENTS))
    return ca.Function("closed_reset", [t, x, p], [passed(reset(t, x, p))], ARGUMENTS, ["state"])


def turning_steps(gait: Gait) -> frozenset[str]:
    """Return the names of the transitions that turn the state back; none where the gait goes straight."""
    if gait.turn == 0.0:
        return frozenset()
    last = gait.pattern.switches[-1]
    steps = landing_steps(gait, last)
    return frozenset(f"{step.source.name}->{step.target.name}" for step in steps if step.source == last.source)
