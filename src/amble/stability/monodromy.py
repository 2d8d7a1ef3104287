"""The derivative of the Poincare map by variational equations.

Shorthand of this file: f the vector field, H the guard, D the reset (t, x) -> x+, all at the event, t the clock of the
domain. Along a domain Phi' = (df/dx) Phi, Phi(0) = 1. A change dx of the entry state moves the event by

    dt = - (dH/dx Phi dx) / (dH/dx f + dH/dt),

and the state after the reset by D_x (Phi dx + f dt) + D_t dt. The factor of a domain, entry to entry, is therefore

    S = D_x Phi - (D_x f + D_t) (H_x Phi) / (H_x f + H_t).                                                      (1)

No field of the next domain occurs, unlike in the saltation matrix D_x + (f+ - D_x f) H_x / (H_x f), because here the
motion stops at the entry instead of running on. Their products along a cycle have the same multipliers but for one: the
textbook's, with the clock as one more state, has besides those of (1) the 1 of the flow's direction. Where nothing
depends on the clock, the textbook's product for x alone has that 1 in place of one 0 of (1).

The multipliers are those of one cycle of the system that is given. A system that closes half a gait cycle by a mirror M
(``gait.closed_loop`` with ``half``) has P = M Q, Q the arc through its domains; the second half of the gait is
M Q M, so the full cycle is M Q M Q = P P, and its multipliers are the squares of those of P.
"""

from __future__ import annotations

from dataclasses import dataclass

import casadi as ca
import numpy as np

from amble.amounts import check_amount
from amble.errors import FallError, WorkError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.hybrid.system import numeric
from amble.names import identifier
from amble.simulation.flow import EventFunction, Flow, FlowDefinition
from amble.simulation.prepared import PreparedDomain, event_functions, margins_of, prepare_domain, prepare_flow
from amble.simulation.walk import MOST_EVENTS, TOO_MANY, explained, longest_step
from amble.stability.derivatives import field_jacobian, slopes
from amble.stability.poincare import TIME_LIMIT, TOLERANCE
from amble.types import Matrix, Vector, frozen

MOST_CYCLES = 10_000
"""Of an orbit, or of one derivative."""

GRAZING = 1e-9
"""A guard whose rate along the field is smaller than this share of its gradient times the field's length grazes."""


TOUCH = 1e-7
"""A guard whose slope at the event is this share of its mean slope from the entry touches zero: where it only touches,
its zero is located to the root of roundoff, and its slope there is of that size."""

TOGETHER = 1e-7
"""Two guards that are reached within this share of the stay in their domain are reached at once."""


@dataclass(frozen=True, kw_only=True)
class Monodromy:
    """The Poincare map and its derivative at a state.

    Attributes:
        image: P(x), (n_x,).
        matrix: dP/dx, (n_x, n_x): the product of the factors, the last domain's leftmost.
        factors: S of every arc, in order, entry to entry, (n_x, n_x).
        durations: of the arcs, s.
        transitions: that ended them, by name.
        entries: of the first domain, after every cycle, (n_cycles, n_x); the last is the image.
    """

    image: Vector
    matrix: Matrix
    factors: tuple[Matrix, ...]
    durations: tuple[float, ...]
    transitions: tuple[str, ...] = ()
    entries: tuple[Vector, ...] = ()

    @property
    def period(self) -> float:
        """Duration of the cycle, or of all cycles of the map, s."""
        return float(sum(self.durations))


@dataclass(frozen=True)
class Variational:
    """The variational equations of a system, prepared for repeated use: one flow of (x, Phi) a domain."""

    system: HybridSystem
    steps: dict[str, tuple[PreparedDomain, Flow]]

    def __call__(
        self,
        state: Vector,
        tolerance: float = TOLERANCE,
        time_limit: float = TIME_LIMIT,
        cycles: int = 1,
        max_step: float | None = None,
    ) -> Monodromy:
        """Return the Poincare map and its derivative; see ``monodromy``."""
        entry = np.array(state, dtype=np.float64).reshape(-1)
        longest = longest_step(time_limit, max_step)
        check_amount("cycles", cycles, 1, MOST_CYCLES)
        total = np.eye(entry.size)
        first = current = self.system.domains[0].name
        arcs: list[_DifferentiatedArc] = []
        entries: list[Vector] = []
        passed = 0
        while len(entries) < cycles:
            if passed >= MOST_EVENTS:
                raise FallError(f"the motion {TOO_MANY} in domain '{current}'")
            done = self._arc(current, entry, tolerance, time_limit, longest)
            arcs.append(done)
            total, entry, current, passed = done.factor @ total, done.after, done.transition.target, passed + 1
            if current == first:
                entries.append(frozen(entry))
                passed = 0
        return Monodromy(
            image=frozen(entry),
            matrix=frozen(total),
            factors=tuple(frozen(done.factor) for done in arcs),
            durations=tuple(done.duration for done in arcs),
            transitions=tuple(done.transition.name for done in arcs),
            entries=tuple(entries),
        )

    def _arc(
        self, name: str, entry: Vector, tolerance: float, time_limit: float, max_step: float
    ) -> _DifferentiatedArc:
        """Move through a domain by the transition that fires."""
        if name not in self.steps:
            domain = self.system.domain(name)
            self.steps[name] = prepare_domain(self.system, name), _flow(domain, self.system.leaving(name))
        here, flow = self.steps[name]
        barrier = here.barred(entry)
        if barrier:
            raise FallError(f"the motion {barrier} at the entry of domain '{name}'")
        size = entry.size
        at_once = here.fired_at(entry)
        if at_once is not None:
            leaving = here.leaving[at_once]
            return _DifferentiatedArc(
                event_factor(here.domain, leaving, 0.0, entry), here.reset(at_once, 0.0, entry), 0.0, leaving
            )
        start = np.concatenate([entry, np.eye(size).reshape(-1)])
        arc = flow(start, tolerance, time_limit, 2, max_step)
        if arc.fired is None:
            place = f"in domain '{name}' after {arc.clock[-1]:.6g} s"
            raise FallError(f"the motion {explained(here, flow, start, arc, place, time_limit)}")
        clock, before = float(arc.clock[-1]), arc.state[-1, :size]
        if not any(item.at_entry for item in self.system.leaving(here.leaving[arc.fired].target)):
            _require_one_guard(here, arc.fired, clock, before)
        transported = arc.state[-1, size:].reshape(size, size, order="F")
        leaving = here.leaving[arc.fired]
        passed = float(leaving.guard(0.0, entry, here.domain.parameters))
        factor = event_factor(here.domain, leaving, clock, before, passed) @ transported
        return _DifferentiatedArc(factor, here.reset(arc.fired, clock, before), clock, leaving)


@dataclass(frozen=True)
class _DifferentiatedArc:
    factor: Matrix
    after: Vector
    duration: float
    transition: Transition


def monodromy(
    system: HybridSystem,
    state: Vector,
    tolerance: float = TOLERANCE,
    time_limit: float = TIME_LIMIT,
    cycles: int = 1,
    max_step: float | None = None,
) -> Monodromy:
    """Differentiate the Poincare map at a state by variational equations.

    A domain may have several exits; the motion takes the one whose guard fires first.

    Args:
        system: the system.
        state: at the entry of the first domain, (n_x,).
        tolerance: of the integrator, relative and absolute, for the state and its derivative alike.
        time_limit: the longest that one domain may last, s.
        cycles: how often the map is applied.
        max_step: the longest time between two event samples, s (``simulate``).

    Raises:
        FallError: where the motion does not come back.
        InputError: where a function cannot be differentiated.
        WorkError: where the orbit only grazes a guard, or reaches two at once, so that the map has no derivative.
    """
    return prepare_variational(system)(state, tolerance, time_limit, cycles, max_step)


def prepare_variational(system: HybridSystem) -> Variational:
    """Build the variational equations of a system, a domain when it is first entered; errors as in ``monodromy``."""
    return Variational(system, {})


def augmented(domain: Domain) -> ca.Function:
    """Return the field of (x, Phi), Phi by columns, as a function (t, (x, Phi), p)."""
    size = domain.state_size
    clock, both, parameters = _symbols(domain)
    state, transported = both[:size], ca.reshape(both[size:], size, size)
    jacobian = ca.densify(field_jacobian(domain)(clock, state, parameters))
    rate = ca.vertcat(domain.field(clock, state, parameters), ca.vec(jacobian @ transported))
    return ca.Function(f"{identifier(domain.name)}_variational", [clock, both, parameters], [rate])


def _flow(domain: Domain, leaving: tuple[Transition, ...]) -> Flow:
    size = domain.state_size
    arguments = _symbols(domain)
    clock, both, parameters = arguments
    lifted = tuple(
        EventFunction(
            ca.Function(f"{item.function.name()}_lifted", arguments, [item.function(clock, both[:size], parameters)]),
            item.direction,
            item.dead_time,
            item.slope_bound,
        )
        for item in event_functions(domain, leaving)
    )
    margins = tuple(margins_of(domain))
    return prepare_flow(FlowDefinition(augmented(domain), domain.parameters, lifted, margins, domain.breakpoints))


def _symbols(domain: Domain) -> list[ca.MX]:
    size = domain.state_size
    return [ca.MX.sym("t"), ca.MX.sym("z", size * (size + 1)), ca.MX.sym("p", domain.parameters.size)]


def _require_one_guard(here: PreparedDomain, fired: int, clock: float, state: Vector) -> None:
    """Raise WorkError where another exit is reached at the same instant: which of them is taken is decided by chance.

    The same guard may lead to one place only, so two exits with one surface are found too.
    """
    domain = here.domain
    rate = numeric(domain.field(clock, state, domain.parameters))
    for number, other in enumerate(here.leaving):
        if number == fired or clock < other.dead_time:
            continue
        value = float(other.guard(clock, state, domain.parameters))
        later = clock + TOGETHER * clock, state + TOGETHER * clock * rate
        change = other.direction * (float(other.guard(*later, domain.parameters)) - value)
        if change > 0.0 and abs(value) <= change:
            raise WorkError(
                f"the orbit reaches the guards of '{here.leaving[fired].name}' and '{other.name}' at once, so its "
                "Poincare map has no derivative"
            )


def event_factor(domain: Domain, leaving: Transition, clock: float, state: Vector, passed: float = 0.0) -> Matrix:
    """Return what stands left of Phi in equation (1), for the state just before the event, (n_x, n_x).

    Args:
        domain: that is left.
        leaving: by which transition.
        clock: of the event, s.
        state: just before it, (n_x,).
        passed: value of the guard at the entry, from where it came to zero; 0 where that is not known.

    Raises:
        WorkError: where the guard has no slope at the event.
    """
    where = (clock, state, domain.parameters)
    guard_x, guard_t = slopes(leaving.guard, f"the guard of '{leaving.name}'", *where)
    reset_x, reset_t = slopes(leaving.reset, f"the reset of '{leaving.name}'", *where)
    rate = np.asarray(domain.field(*where).full()).reshape(-1)
    crossing = float((guard_x @ rate + guard_t).item())
    steepest = np.linalg.norm(guard_x) * np.linalg.norm(rate) + abs(guard_t.item())
    if abs(crossing) < GRAZING * steepest or abs(crossing) * clock < TOUCH * abs(passed):
        raise WorkError(f"the orbit only grazes the guard of '{leaving.name}', so its Poincare map has no derivative")
    return reset_x - np.outer(reset_x @ rate + reset_t, guard_x) / crossing
