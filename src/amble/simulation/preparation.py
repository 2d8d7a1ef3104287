"""Preparing the flow through a domain: in native code where that can be had, else with scipy."""

from __future__ import annotations

from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import interpreted, native
from amble.simulation.flow import EventFunction, Flow, FlowDefinition


def prepare(system: HybridSystem, name: str) -> Flow:
    """Prepare the flow through a domain of a system, in native code where that can be had."""
    domain = system.domain(name)
    events = event_functions(domain, system.leaving(name))
    return prepare_flow(
        FlowDefinition(domain.field, domain.parameters, events, domain.admissibility is not None, domain.breakpoints)
    )


def prepare_flow(definition: FlowDefinition) -> Flow:
    """Prepare a flow from functions, in native code where that can be had."""
    flow = native.prepare(definition)
    return interpreted.prepare(definition) if flow is None else flow


def event_functions(domain: Domain, leaving: tuple[Transition, ...]) -> tuple[EventFunction, ...]:
    """List the guards in the order of the transitions, then the margin of the domain where it has one."""
    guards = [
        EventFunction(transition.guard, transition.direction, transition.dead_time, transition.slope_bound)
        for transition in leaving
    ]
    margin = [] if domain.admissibility is None else [EventFunction(domain.admissibility, -1, 0.0)]
    return (*guards, *margin)
