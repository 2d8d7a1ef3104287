"""A guard that is zero at the entry and about to fire: from a start beside the section it fires at once."""

from __future__ import annotations

import numpy as np

from amble.hybrid import HybridSystem, Transition
from amble.hybrid.system import numeric
from amble.types import Vector

BESIDE = 1e-6
"""How far the state moves while it is seen where a guard goes, as a share of 1 + |x|."""


def depends_on_clock(transition: Transition) -> bool:
    """Whether the guard of a transition may be moved by the clock alone."""
    try:
        return bool(transition.guard.jac_sparsity(0, 0).nnz())
    except RuntimeError:  # compiled without derivatives: nothing is known
        return True


def missing_dead_time(system: HybridSystem, state: Vector) -> str:
    """Name the guard of the first domain that needs a dead time; empty where none does.

    The guard of a section through a smooth cycle is zero at the entry and passes on in its direction. It does not fire
    there; but from a start that is moved back a little it would, and the return map of such starts is no map around the
    orbit.

    Args:
        system: the system.
        state: a state at the entry of the first domain, on the section, (n_x,).
    """
    domain = system.domains[0]
    rate = numeric(domain.field(0.0, state, domain.parameters))
    speed = float(np.linalg.norm(rate))
    ahead = BESIDE * (1.0 + float(np.linalg.norm(state))) / (speed if speed > 0.0 else 1.0)
    for transition in system.leaving(domain.name):
        here, there = (
            transition.direction * float(transition.guard(clock, state + clock * rate, domain.parameters))
            for clock in (0.0, ahead)
        )
        if transition.dead_time == 0.0 and abs(here) <= there - here:
            return (
                f"the guard of '{transition.name}' is zero at the entry of '{domain.name}' and about to fire, so from "
                "a start beside it it fires at once: give the transition a dead_time"
            )
    return ""
