"""A hybrid dynamical system: domains with vector fields, joined by guards and resets in a directed cycle.

This record is all that simulation and stability know; a legged robot is one way to build one.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import casadi as ca
import numpy as np

from amble.errors import InputError, UnknownNameError
from amble.names import check_name, identifier
from amble.types import Vector, frozen

FIELD_ARGUMENTS = ("t", "x", "p")


@dataclass(frozen=True, kw_only=True)
class Domain:
    """A vertex of the graph: where one vector field holds.

    Attributes:
        name: the domain's name.
        field: casadi function (t, x, p) -> dx/dt; t is the clock, which restarts at each entry (s).
        parameters: the value of p, shape (n_p,).
        signals: optional casadi function (t, x, p) -> named outputs, recorded along a simulation; the names are
            those of the function's outputs.
        jacobian: optional casadi function (t, x, p) -> d field / d x, where a faster one than automatic
            differentiation of ``field`` is known.
        admissibility: optional casadi function (t, x, p) -> scalar margin, positive inside the domain of
            admissibility; a simulation that leaves it ends there and says so (a fall).
        breakpoints: clock values, ascending, at which the field is continuous but not smooth (the end of a planned
            reference). An integrator ends a step there; without it, it would search for the breakpoint with many steps.
    """

    name: str
    field: ca.Function
    parameters: Vector = field(default_factory=lambda: frozen([]))
    signals: ca.Function | None = None
    jacobian: ca.Function | None = None
    admissibility: ca.Function | None = None
    breakpoints: tuple[float, ...] = ()

    def __post_init__(self) -> None:
        """Check the name."""
        check_name("domain", self.name)

    @classmethod
    def from_expressions(
        cls,
        name: str,
        state: ca.SX,
        rate: ca.SX,
        clock: ca.SX | None = None,
        signals: dict[str, ca.SX] | None = None,
        admissibility: ca.SX | None = None,
    ) -> Domain:
        """Build a domain from symbols: the state, its rate and, where the rate depends on it, the clock."""
        clock = ca.SX.sym("t") if clock is None else clock
        parameters = ca.SX.sym("p", 0)
        symbols = [clock, state, parameters]
        label = identifier(name)
        rate_function = ca.Function(f"{label}_field", symbols, [ca.densify(rate)], FIELD_ARGUMENTS, ["rate"])
        signal_function = None
        if signals:
            signal_function = ca.Function(
                f"{label}_signals", symbols, list(signals.values()), FIELD_ARGUMENTS, list(signals)
            )
        admissibility_function = None
        if admissibility is not None:
            admissibility_function = ca.Function(
                f"{label}_alive", symbols, [admissibility], FIELD_ARGUMENTS, ["margin"]
            )
        return cls(
            name=name,
            field=rate_function,
            parameters=frozen([]),
            signals=signal_function,
            admissibility=admissibility_function,
        )

    @property
    def state_size(self) -> int:
        """Number of states.

        Raises:
            InputError: the field does not take (t, x, p).
        """
        _expect_arguments(f"field of domain '{self.name}'", self.field)
        return int(self.field.numel_in(1))


@dataclass(frozen=True, kw_only=True)
class Transition:
    """An edge of the graph: leave ``source`` when the guard crosses zero, enter ``target`` through the reset.

    The crossing counts when the guard passes zero in ``direction`` (-1: falling, +1: rising) at a clock time t with
    0 < t <= t_end: a guard that is zero at the start of a domain does not fire there, and one that starts on the far
    side must come back before it can fire. So a swing foot that has just lifted (height 0, rising) fires when it lands,
    and a crossing in the other direction (a leg that scuffs at mid-stance) does not count.

    Attributes:
        source: name of the domain that is left.
        target: name of the domain that is entered.
        guard: casadi function (t, x, p) -> scalar, with the parameters of the source domain.
        reset: casadi function (t, x, p) -> state at the entry of the target, parameters of the source domain.
        direction: -1 or +1.
        dead_time: clock before which the guard is not looked at, s. It makes the rule above robust: from a start that
            is perturbed off the section, a guard that should be zero there would cross at once.
    """

    source: str
    target: str
    guard: ca.Function
    reset: ca.Function
    direction: int = -1
    dead_time: float = 0.0

    @classmethod
    def from_expressions(
        cls,
        source: str,
        target: str,
        state: ca.SX,
        guard: ca.SX,
        reset: ca.SX,
        direction: int = -1,
        clock: ca.SX | None = None,
        dead_time: float = 0.0,
    ) -> Transition:
        """Build a transition from symbols of the source domain."""
        clock = ca.SX.sym("t") if clock is None else clock
        symbols = [clock, state, ca.SX.sym("p", 0)]
        label = f"{identifier(source)}_{identifier(target)}"
        return cls(
            source=source,
            target=target,
            guard=ca.Function(f"{label}_guard", symbols, [guard], FIELD_ARGUMENTS, ["guard"]),
            reset=ca.Function(f"{label}_reset", symbols, [ca.densify(reset)], FIELD_ARGUMENTS, ["state"]),
            direction=direction,
            dead_time=dead_time,
        )

    @property
    def name(self) -> str:
        """Source and target."""
        return f"{self.source}->{self.target}"


@dataclass(frozen=True)
class Symmetry:
    """A one-parameter group under which the system is invariant, by its generator x -> xi(x).

    Along it an orbit is neutral by construction (multiplier 1, or -1 where a reset reverses it), so the stability
    analysis takes it out on purpose and says so.
    """

    name: str
    generator: ca.Function

    def __post_init__(self) -> None:
        """Check the name."""
        check_name("symmetry", self.name)


@dataclass(frozen=True)
class HybridSystem:
    """A directed cycle of domains; it validates itself on construction, and keeps lists as tuples.

    Attributes:
        domains: where the vector fields hold; a cycle starts with the first.
        transitions: how one domain is left for another.
        symmetries: under which the system is invariant.
        state_names: of the entries of x; x0, x1, ... where none are given.

    Raises:
        InputError: where there is no domain, a name occurs twice, state sizes differ, a domain has no way out or
            cannot be reached, a guard's direction is not -1 or +1, or its dead time is negative.
    """

    domains: Sequence[Domain]
    transitions: Sequence[Transition]
    symmetries: Sequence[Symmetry] = ()
    state_names: Sequence[str] = ()

    def __post_init__(self) -> None:
        """Freeze the sequences, name the states where nobody did, and check that all fits together."""
        if self.domains and not self.state_names:
            object.__setattr__(self, "state_names", [f"x{i}" for i in range(self.domains[0].state_size)])
        for part in fields(self):
            object.__setattr__(self, part.name, tuple(getattr(self, part.name)))
        _validate(self)

    @property
    def state_size(self) -> int:
        """Number of states, the same in every domain."""
        return self.domains[0].state_size

    def domain(self, name: str) -> Domain:
        """Look a domain up by name."""
        for candidate in self.domains:
            if candidate.name == name:
                return candidate
        raise UnknownNameError("domain", name, [d.name for d in self.domains])

    def leaving(self, name: str) -> tuple[Transition, ...]:
        """Return the transitions that leave a domain."""
        self.domain(name)
        return tuple(t for t in self.transitions if t.source == name)

    def cycle(self) -> tuple[tuple[Domain, Transition], ...]:
        """Return the domains in the order of one cycle from the first, each with the transition that leaves it.

        Raises:
            InputError: where a domain has more than one successor, so that the cycle is not determined.
        """
        steps: list[tuple[Domain, Transition]] = []
        name = self.domains[0].name
        while not steps or name != self.domains[0].name:
            leaving = self.leaving(name)
            if len(leaving) != 1 or len(steps) > len(self.domains):
                raise InputError(f"the graph is not one cycle: domain '{name}' has {len(leaving)} successors")
            steps.append((self.domain(name), leaving[0]))
            name = leaving[0].target
        return tuple(steps)


def _validate(system: HybridSystem) -> None:
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


def _validate_transition(system: HybridSystem, transition: Transition) -> None:
    size = system.state_size
    system.domain(transition.source)
    system.domain(transition.target)
    if transition.direction not in (-1, 1):
        raise InputError(f"direction of '{transition.name}' is {transition.direction}; known: -1, +1")
    if not transition.dead_time >= 0:
        raise InputError(f"the dead time of '{transition.name}' is {transition.dead_time:g} s, below 0")
    _expect_shape(f"guard of '{transition.name}'", transition.guard, size, 1)
    _expect_shape(f"reset of '{transition.name}'", transition.reset, size, size)


def _validate_symmetry(symmetry: Symmetry, size: int) -> None:
    generator = symmetry.generator
    if (generator.numel_in(0), generator.numel_out(0)) != (size, size):
        raise InputError(
            f"the generator of symmetry '{symmetry.name}' maps {generator.numel_in(0)} states to "
            f"{generator.numel_out(0)} rates, not {size} of each"
        )


def _validate_domain(system: HybridSystem, domain: Domain) -> None:
    size = system.state_size
    _expect_shape(f"field of domain '{domain.name}'", domain.field, size, size)
    if domain.admissibility is not None:
        _expect_shape(f"margin of domain '{domain.name}'", domain.admissibility, size, 1)
    for what, function in (("signals", domain.signals), ("jacobian", domain.jacobian)):
        if function is not None:
            _expect_state(f"{what} of domain '{domain.name}'", function, size)
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
    _expect_arguments(what, function)
    if function.numel_in(1) != size_in or function.numel_out(0) != size_out:
        raise InputError(
            f"the {what} maps {function.numel_in(1)} states to {function.numel_out(0)} values, "
            f"not {size_in} to {size_out}"
        )


def _expect_state(what: str, function: ca.Function, size: int) -> None:
    _expect_arguments(what, function)
    if function.numel_in(1) != size:
        raise InputError(f"the {what} takes {function.numel_in(1)} states, not {size}")


def _expect_arguments(what: str, function: ca.Function) -> None:
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


def numeric(value: Any) -> Vector:
    """Flatten a casadi result to a numpy vector."""
    return np.asarray(value, dtype=np.float64).reshape(-1, order="F")
