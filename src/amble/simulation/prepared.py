"""A domain prepared for motions, and the flow through it: in native code where that can be had, else with scipy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.hybrid import Domain, HybridSystem, Transition
from amble.hybrid.system import numeric
from amble.simulation import interpreted, native
from amble.simulation.bound import Bound, bind
from amble.simulation.flow import LEFT_DOMAIN, RESOLUTION, STUCK, EventFunction, Flow, FlowDefinition
from amble.types import Vector


@dataclass(frozen=True)
class PreparedDomain:
    """A domain prepared for motions through it: its place in the system, its margins and the resets that leave it."""

    number: int
    domain: Domain
    leaving: tuple[Transition, ...]
    margins: Mapping[str, Bound]
    resets: tuple[Bound, ...]

    def barred(self, entry: Vector) -> str:
        """Say why a motion cannot begin here (``Arc.ended``); empty where it can."""
        if not np.all(np.isfinite(entry)):
            return STUCK
        return next((what for what, margin in self.margins.items() if not margin(0.0, entry)[0][0] > 0), "")

    def fired_at(self, entry: Vector) -> int | None:
        """Return which transition fires at the entry (``Transition.at_entry``), by its place; None where none does."""
        if not any(transition.at_entry for transition in self.leaving):
            return None
        rate = numeric(self.domain.field(0.0, entry, self.domain.parameters))
        ahead = entry + RESOLUTION * rate
        for number, transition in enumerate(self.leaving):
            value = float(transition.guard(RESOLUTION, ahead, self.domain.parameters))
            if transition.at_entry and transition.direction * value >= 0.0:
                return number
        return None

    def reset(self, fired: int, clock: float, state: Vector) -> Vector:
        """Return the state after the reset of a transition that leaves the domain, (n_x,)."""
        return self.resets[fired](clock, state)[0]


def prepare_domain(system: HybridSystem, name: str) -> PreparedDomain:
    """Prepare a domain of a system."""
    domain, leaving = system.domain(name), system.leaving(name)
    margins = {what: bind(margin, domain.parameters) for what, margin in margins_of(domain).items()}
    resets = tuple(bind(transition.reset, domain.parameters) for transition in leaving)
    return PreparedDomain(
        [candidate.name for candidate in system.domains].index(name), domain, leaving, margins, resets
    )


def prepare(system: HybridSystem, name: str) -> Flow:
    """Prepare the flow through a domain of a system, in native code where that can be had."""
    domain = system.domain(name)
    events = event_functions(domain, system.leaving(name))
    return prepare_flow(
        FlowDefinition(domain.field, domain.parameters, events, tuple(margins_of(domain)), domain.breakpoints)
    )


def prepare_flow(definition: FlowDefinition) -> Flow:
    """Prepare a flow from functions, in native code where that can be had."""
    flow = native.prepare(definition)
    return interpreted.prepare(definition) if flow is None else flow


def event_functions(domain: Domain, leaving: tuple[Transition, ...]) -> tuple[EventFunction, ...]:
    """List the guards in the order of the transitions, then the margins of the domain."""
    guards = [
        EventFunction(transition.guard, transition.direction, transition.dead_time, transition.slope_bound)
        for transition in leaving
    ]
    return (*guards, *(EventFunction(margin, -1, 0.0) for margin in margins_of(domain).values()))


def margins_of(domain: Domain) -> dict[str, ca.Function]:
    """Return all margins of a domain with what a motion has done that leaves it: it fell, or what the domain says."""
    fall = {} if domain.admissibility is None else {LEFT_DOMAIN: domain.admissibility}
    return fall | dict(domain.margins)
