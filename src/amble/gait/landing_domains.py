"""The closed loop where feet land one by one: a domain for the feet that have landed so far, in every order.

Between two landings the legs of the feet that have still to land go on at the rates of their joints; the other joints
have the torques that the law of the stance that comes next gives at its entry, for the velocities that the rest of its
feet leaves: those behind the impact that would stop all of them. The clock of the stance begins when the last foot
lands, and any feedback law can be used. A law may have references of its own there instead
(``ControlLaw.landing_numbers``). Where the feet come down at once such a domain lasts no time, and the state behind it
is that of the impact on all feet (docs/theory/hybrid-model.md, section 10).
"""

from __future__ import annotations

from math import inf

import casadi as ca

from amble.control.closed_loop import StanceLoop
from amble.control.landing import compiled_gap, compiled_landing_plant, compiled_stopping
from amble.control.stance_functions import ARGUMENTS
from amble.gait.cycle_end import StateMap
from amble.hybrid import Contacts, Domain, GaitPattern, Stance, Transition

DIFFERENCE = 1e-6
"""Step of the differences that give the slope of the field between two landings, in the states' units: it counts only
off the orbit, where such a domain lasts."""


def landing_domain(
    pattern: GaitPattern, loop: StanceLoop, following: Domain, next_stance: Stance, stance: Stance
) -> Domain:
    """Close the loop between landings into a solved stance.

    Args:
        pattern: the gait pattern.
        loop: of the solved stance that follows; its torques are a signal.
        following: its domain.
        next_stance: that stance.
        stance: the feet on the ground.
    """
    late = tuple(foot for foot in next_stance.feet if foot not in stance.feet)
    stopped = compiled_stopping(pattern.contacts(next_stance))
    moved = compiled_landing_plant(pattern.contacts(stance), late)
    t, x, p = (ca.MX.sym(name, following.field.numel_in(i)) for i, name in enumerate(ARGUMENTS))
    law = dict(zip(loop.signals.name_out(), loop.signals(0.0, stopped(x), p), strict=True))
    rate, force, torque = moved(x, law["torque"])
    field = ca.Function("landing_field", [t, x, p], [rate], ARGUMENTS, ["rate"])
    recorded = dict(zip(loop.signals.name_out(), loop.signals(0.0, x, p), strict=True))
    recorded |= {"torque": torque, "force": force, "pivot": law["pivot"]}
    return Domain(
        name=stance.name,
        field=field,
        parameters=following.parameters,
        signals=ca.Function("landing_signals", [t, x, p], list(recorded.values()), ARGUMENTS, list(recorded)),
        jacobian=_differences(field),
        admissibility=following.admissibility,
    )


def landing_transition(
    contacts: Contacts, foot: str, source: Domain, target: str, first: bool, closing: StateMap | None = None
) -> Transition:
    """Return the landing of one foot.

    Args:
        contacts: feet on the ground afterwards.
        foot: that lands.
        source: the domain that it ends.
        target: name of the domain that follows.
        first: whether it is the first landing of its switch.
        closing: what the state passes after it, where it begins the next cycle.
    """
    gap, stopped = compiled_gap(contacts, foot), compiled_stopping(contacts)
    t, x, p = (ca.MX.sym(name, source.field.numel_in(i)) for i, name in enumerate(ARGUMENTS))
    after = stopped(x) if closing is None else closing(stopped(x))
    return Transition(
        source=source.name,
        target=target,
        guard=ca.Function("landing_gap", [t, x, p], [gap(x)], ARGUMENTS, ["guard"]),
        reset=ca.Function("landing_reset", [t, x, p], [after], ARGUMENTS, ["state"]),
        at_entry=not first,
    )


def continued(domain: Domain, landing: Transition) -> tuple[Domain, tuple[Transition, ...]]:
    """Continue a landing smoothly to where its foot was down before its turn: the motion goes back to its touchdown.

    A domain between two landings then lasts a negative time. No robot moves so; it is what one order's derivative is
    the derivative of, on both sides of the orbit.

    Args:
        domain: between two landings.
        landing: the only one that leaves it.

    Returns:
        The domain that runs back, and the transitions of both.
    """
    t, x, p = (ca.MX.sym(name, domain.field.numel_in(i)) for i, name in enumerate(ARGUMENTS))
    back = Domain(
        name=f"{domain.name} back",
        field=(field := ca.Function("back", [t, x, p], [-domain.field(-t, x, p)], ARGUMENTS, ["rate"])),
        parameters=domain.parameters,
        jacobian=_differences(field),
    )
    same = ca.Function("same", [t, x, p], [x], ARGUMENTS, ["state"])
    # the state leaves for the way back at the entry or not at all
    leaves = Transition(
        source=domain.name, target=back.name, guard=landing.guard, reset=same, dead_time=inf, at_entry=True
    )
    returns = Transition(
        source=back.name, target=landing.target, guard=landing.guard, reset=landing.reset, direction=1, at_entry=True
    )
    onward = Transition(source=domain.name, target=landing.target, guard=landing.guard, reset=landing.reset)
    return back, (onward, leaves, returns)


def _differences(field: ca.Function) -> ca.Function:
    """Slope of a field in x by central differences, (t, x, p) -> (n_x, n_x)."""
    t, x, p = (ca.MX.sym(name, field.numel_in(i)) for i, name in enumerate(ARGUMENTS))
    steps_of = DIFFERENCE * ca.DM.eye(x.numel())
    columns = [field(t, x + step, p) - field(t, x - step, p) for step in ca.horzsplit(steps_of)]
    slope = ca.horzcat(*columns) * (0.5 / DIFFERENCE)
    return ca.Function("landing_jacobian", [t, x, p], [slope], ARGUMENTS, ["jacobian"])
