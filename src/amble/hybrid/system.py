"""A hybrid dynamical system: domains with vector fields, joined by guards and resets in a directed cycle.

This record is all that simulation and stability know; a legged robot is one way to build one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from math import inf
from typing import Any

import casadi as ca
import numpy as np

from amble.errors import InputError, UnknownNameError
from amble.hybrid.validation import arguments, expect_arguments, function, validate
from amble.names import check_name, identifier
from amble.types import Vector, frozen


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
        margins: more such margins, each with what a motion has done that leaves it, in words: what -> function.
        breakpoints: clock values, ascending, at which the field is continuous but not smooth (the end of a planned
            reference). An integrator ends a step there; without it, it would search for the breakpoint with many steps.
    """

    name: str
    field: ca.Function
    parameters: Vector = field(default_factory=lambda: frozen([]))
    signals: ca.Function | None = None
    jacobian: ca.Function | None = None
    admissibility: ca.Function | None = None
    margins: Mapping[str, ca.Function] = field(default_factory=dict)
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
        parameters: ca.SX | None = None,
        values: Sequence[float] | Vector = (),
    ) -> Domain:
        """Build a domain from symbols.

        Args:
            name: the domain's name.
            state: symbol of the state, (n_x,).
            rate: its rate, (n_x,).
            clock: symbol of the clock, where anything depends on it.
            signals: name -> expression; names are words of letters, digits and single underscores.
            admissibility: the margin, scalar.
            parameters: symbol of p, where anything depends on it, (n_p,).
            values: of p, (n_p,).

        Raises:
            InputError: symbols that are not of casadi's kind SX, or an expression with a symbol that is not given.
        """
        check_name("domain", name)
        symbols = arguments(state, clock, parameters)
        label, whose = identifier(name), f"of domain '{name}'"
        return cls(
            name=name,
            field=function(f"{label}_field", f"rate {whose}", symbols, {"rate": rate}),
            parameters=frozen(values),
            signals=function(f"{label}_signals", f"signals {whose}", symbols, signals) if signals else None,
            admissibility=None
            if admissibility is None
            else function(f"{label}_alive", f"margin {whose}", symbols, {"margin": admissibility}),
        )

    @property
    def state_size(self) -> int:
        """Number of states.

        Raises:
            InputError: the field does not take (t, x, p).
        """
        expect_arguments(f"field of domain '{self.name}'", self.field)
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
        at_entry: whether the guard fires at the entry, clock 0, too where it is past zero there or about to be: a foot
            that reached the ground together with the one whose landing led here.
        slope_bound: a bound on |dH/dt| along every motion through the source, in the guard's unit per second. With it
            no crossing is missed, however short; without (infinite), none longer than ``max_step``.
    """

    source: str
    target: str
    guard: ca.Function
    reset: ca.Function
    direction: int = -1
    dead_time: float = 0.0
    slope_bound: float = inf
    at_entry: bool = False

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
        parameters: ca.SX | None = None,
        slope_bound: float = inf,
        at_entry: bool = False,
    ) -> Transition:
        """Build a transition from symbols of the source domain: its state, clock and parameters.

        Raises:
            InputError: as in ``Domain.from_expressions``.
        """
        check_name("domain", source)
        check_name("domain", target)
        symbols = arguments(state, clock, parameters)
        label, whose = f"{identifier(source)}_{identifier(target)}", f"of '{source}->{target}'"
        return cls(
            source=source,
            target=target,
            guard=function(f"{label}_guard", f"guard {whose}", symbols, {"guard": guard}),
            reset=function(f"{label}_reset", f"reset {whose}", symbols, {"state": reset}),
            direction=direction,
            dead_time=dead_time,
            slope_bound=slope_bound,
            at_entry=at_entry,
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
class Invariant:
    """A conserved quantity: a function x -> scalar of the entry state that a cycle keeps, as the energy of a hopper.

    Periodic orbits then come in families, one for every value, and the multiplier 1 across the values says nothing of
    the motion. A fixed point keeps the value of its guess, and its stability is that among motions of the same value.
    """

    name: str
    function: ca.Function

    def __post_init__(self) -> None:
        """Check the name."""
        check_name("invariant", self.name)


@dataclass(frozen=True)
class HybridSystem:
    """A directed graph of domains; it validates itself on construction, and keeps lists as tuples.

    Attributes:
        domains: where the vector fields hold; a cycle starts with the first.
        transitions: how one domain is left for another.
        symmetries: under which the system is invariant.
        state_names: of the entries of x; x0, x1, ... where none are given.
        invariants: what a cycle conserves.

    Raises:
        InputError: where there is no domain, a name occurs twice, state sizes differ, a domain has no way out or
            cannot be reached, a guard's direction is not -1 or +1, or its dead time or slope bound is out of range.
    """

    domains: Sequence[Domain]
    transitions: Sequence[Transition]
    symmetries: Sequence[Symmetry] = ()
    state_names: Sequence[str] = ()
    invariants: Sequence[Invariant] = ()

    def __post_init__(self) -> None:
        """Freeze the sequences, name the states where nobody did, and check that all fits together."""
        if self.domains and not self.state_names:
            object.__setattr__(self, "state_names", [f"x{i}" for i in range(self.domains[0].state_size)])
        for part in fields(self):
            object.__setattr__(self, part.name, tuple(getattr(self, part.name)))
        validate(self)

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


def numeric(value: Any) -> Vector:
    """Flatten a casadi result to a numpy vector."""
    return np.asarray(value, dtype=np.float64).reshape(-1, order="F")
