"""Whether the parts of a hybrid system fit together: its graph, the shapes of its functions, its numbers."""

from __future__ import annotations

import itertools
from typing import TYPE_CHECKING

import casadi as ca

from amble.errors import InputError
from amble.hybrid.expressions import FIELD_ARGUMENTS

if TYPE_CHECKING:
    from amble.hybrid.system import Domain, HybridSystem, Invariant, Symmetry, Transition


def validate(system: HybridSystem) -> None:
    """Raise InputError where the graph or the shapes do not fit together."""
    names = [domain.name for domain in system.domains]
    if not names:
        raise InputError("a hybrid system needs at least one domain")
    if len(set(names)) != len(names):
        raise InputError(f"domain names occur twice: {names}")
    size = system.state_size
    for domain in system.domains:
        _validate_domain(system, domain)
    for transition in system.transitions:
        _validate_transition(system, transition)
    for symmetry in system.symmetries:
        _validate_symmetry(symmetry, size)
    reached = _reachable(system, names[0])
    for name in names:
        if name not in reached:
            raise InputError(f"domain '{name}' cannot be reached from '{names[0]}'")
    if len(system.state_names) != size:
        raise InputError(f"{len(system.state_names)} state names for {size} states")
    for invariant in system.invariants:
        _validate_invariant(invariant, size)


def _validate_invariant(invariant: Invariant, size: int) -> None:
    called = invariant.function
    if called.n_in() != 1 or (called.numel_in(0), called.numel_out(0)) != (size, 1):
        raise InputError(f"invariant '{invariant.name}' is no function of {size} states with one value")


def _validate_symmetry(symmetry: Symmetry, size: int) -> None:
    generator = symmetry.generator
    if (generator.numel_in(0), generator.numel_out(0)) != (size, size):
        raise InputError(
            f"the generator of symmetry '{symmetry.name}' maps {generator.numel_in(0)} states to "
            f"{generator.numel_out(0)} rates, not {size} of each"
        )


def _validate_transition(system: HybridSystem, transition: Transition) -> None:
    size = system.state_size
    source = system.domain(transition.source)
    system.domain(transition.target)
    if transition.direction not in (-1, 1):
        raise InputError(f"direction of '{transition.name}' is {transition.direction}; known: -1, +1")
    if not transition.dead_time >= 0:
        raise InputError(f"the dead time of '{transition.name}' is {transition.dead_time:g} s, below 0")
    if not transition.slope_bound > 0:
        raise InputError(f"the slope bound of '{transition.name}' is {transition.slope_bound:g}, not above 0")
    _expect_shape(f"guard of '{transition.name}'", transition.guard, size, 1)
    _expect_shape(f"reset of '{transition.name}'", transition.reset, size, size)
    for what, called in (("guard", transition.guard), ("reset", transition.reset)):
        if called.numel_in(2) != source.parameters.size:
            raise InputError(
                f"the {what} of '{transition.name}' takes {called.numel_in(2)} parameters, and domain "
                f"'{source.name}' has {source.parameters.size}"
            )


def _validate_domain(system: HybridSystem, domain: Domain) -> None:
    size = system.state_size
    _expect_shape(f"field of domain '{domain.name}'", domain.field, size, size)
    if domain.admissibility is not None:
        _expect_shape(f"margin of domain '{domain.name}'", domain.admissibility, size, 1)
    for what, called in (("signals", domain.signals), ("jacobian", domain.jacobian)):
        if called is not None:
            _expect_state(f"{what} of domain '{domain.name}'", called, size)
    if domain.field.numel_in(2) != domain.parameters.size:
        raise InputError(
            f"domain '{domain.name}' has {domain.parameters.size} parameters, not {domain.field.numel_in(2)}"
        )
    if not all(earlier < later for earlier, later in itertools.pairwise((0.0, *domain.breakpoints))):
        raise InputError(
            f"the breakpoints of domain '{domain.name}' are not positive and ascending: {domain.breakpoints}"
        )
    if not system.leaving(domain.name):
        raise InputError(f"domain '{domain.name}' has no transition that leaves it")


def _expect_shape(what: str, function: ca.Function, size_in: int, size_out: int) -> None:
    expect_arguments(what, function)
    if function.numel_in(1) != size_in or function.numel_out(0) != size_out:
        raise InputError(
            f"the {what} maps {function.numel_in(1)} states to {function.numel_out(0)} values, "
            f"not {size_in} to {size_out}"
        )


def _expect_state(what: str, function: ca.Function, size: int) -> None:
    expect_arguments(what, function)
    if function.numel_in(1) != size:
        raise InputError(f"the {what} takes {function.numel_in(1)} states, not {size}")


def expect_arguments(what: str, function: ca.Function) -> None:
    """Raise InputError where a function does not take (t, x, p)."""
    if function.n_in() != len(FIELD_ARGUMENTS):
        raise InputError(f"the {what} takes {function.n_in()} arguments, not (t, x, p)")


def _reachable(system: HybridSystem, start: str) -> set[str]:
    reached, frontier = {start}, [start]
    while frontier:
        for transition in system.leaving(frontier.pop()):
            if transition.target not in reached:
                reached.add(transition.target)
                frontier.append(transition.target)
    return reached
