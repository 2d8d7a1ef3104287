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

from amble.errors import FallError, WorkError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.names import identifier
from amble.simulation.flow import EventFunction, Flow, FlowDefinition
from amble.simulation.preparation import event_functions, prepare_flow
from amble.simulation.walk import PreparedDomain, prepare_domain
from amble.stability.derivatives import field_jacobian, slopes
from amble.stability.poincare import TIME_LIMIT, TOLERANCE
from amble.types import Matrix, Vector, frozen

GRAZING = 1e-9
"""A guard whose rate along the field is smaller than this share of its gradient times the field's length grazes."""


@dataclass(frozen=True)
class Monodromy:
    """The Poincare map and its derivative at a state.

    Attributes:
        image: P(x), (n_x,).
        matrix: dP/dx, (n_x, n_x): the product of the factors, the last domain's leftmost.
        factors: S of every domain of the cycle, in order, entry to entry, (n_x, n_x).
        durations: of the domains, s.
    """

    image: Vector
    matrix: Matrix
    factors: tuple[Matrix, ...]
    durations: tuple[float, ...]

    @property
    def period(self) -> float:
        """Duration of the cycle, s."""
        return float(sum(self.durations))


@dataclass(frozen=True)
class Variational:
    """The variational equations of a system, prepared for repeated use: one flow of (x, Phi) a domain."""

    steps: tuple[tuple[PreparedDomain, Flow], ...]

    def __call__(self, state: Vector, tolerance: float = TOLERANCE, time_limit: float = TIME_LIMIT) -> Monodromy:
        """Return the Poincare map and its derivative; see ``monodromy``."""
        entry = np.array(state, dtype=np.float64).reshape(-1)
        size = entry.size
        factors, durations = [], []
        total = np.eye(size)
        for here, flow in self.steps:
            domain, transition = here.domain, here.leaving[0]
            barrier = here.barred(entry)
            if barrier:
                raise FallError(f"the motion {barrier} at the entry of domain '{domain.name}'")
            start = np.concatenate([entry, np.eye(size).reshape(-1)])
            passed = flow(start, tolerance, time_limit, 2)
            if passed.fired is None:
                raise FallError(f"the motion {passed.ended} in domain '{domain.name}' after {passed.clock[-1]:.6g} s")
            clock, before = float(passed.clock[-1]), passed.state[-1, :size]
            transported = passed.state[-1, size:].reshape(size, size, order="F")
            factor = event_factor(domain, transition, clock, before) @ transported
            entry = here.reset(0, clock, before)
            total = factor @ total
            factors.append(frozen(factor))
            durations.append(clock)
        return Monodromy(frozen(entry), frozen(total), tuple(factors), tuple(durations))


def monodromy(
    system: HybridSystem, state: Vector, tolerance: float = TOLERANCE, time_limit: float = TIME_LIMIT
) -> Monodromy:
    """Differentiate the Poincare map at a state by variational equations.

    Args:
        system: the system; its domains form one cycle.
        state: at the entry of the first domain, (n_x,).
        tolerance: of the integrator, relative and absolute, for the state and its derivative alike.
        time_limit: the longest that one domain may last, s.

    Raises:
        FallError: where the motion does not come back.
        InputError: where the graph is not one cycle, or a function cannot be differentiated.
        WorkError: where the orbit only grazes a guard, so that the map has no derivative.
    """
    return prepare_variational(system)(state, tolerance, time_limit)


def prepare_variational(system: HybridSystem) -> Variational:
    """Build the variational equations of a system; errors as in ``monodromy``."""
    return Variational(
        tuple((prepare_domain(system, domain.name), _flow(domain, leaving)) for domain, leaving in system.cycle())
    )


def augmented(domain: Domain) -> ca.Function:
    """Return the field of (x, Phi), Phi by columns, as a function (t, (x, Phi), p)."""
    size = domain.state_size
    clock, both, parameters = _symbols(domain)
    state, transported = both[:size], ca.reshape(both[size:], size, size)
    jacobian = ca.densify(field_jacobian(domain)(clock, state, parameters))
    rate = ca.vertcat(domain.field(clock, state, parameters), ca.vec(jacobian @ transported))
    return ca.Function(f"{identifier(domain.name)}_variational", [clock, both, parameters], [rate])


def _flow(domain: Domain, leaving: Transition) -> Flow:
    size = domain.state_size
    arguments = _symbols(domain)
    clock, both, parameters = arguments
    lifted = tuple(
        EventFunction(
            ca.Function(f"{item.function.name()}_lifted", arguments, [item.function(clock, both[:size], parameters)]),
            item.direction,
            item.dead_time,
        )
        for item in event_functions(domain, (leaving,))
    )
    has_margin = domain.admissibility is not None
    return prepare_flow(FlowDefinition(augmented(domain), domain.parameters, lifted, has_margin, domain.breakpoints))


def _symbols(domain: Domain) -> list[ca.MX]:
    size = domain.state_size
    return [ca.MX.sym("t"), ca.MX.sym("z", size * (size + 1)), ca.MX.sym("p", domain.parameters.size)]


def event_factor(domain: Domain, leaving: Transition, clock: float, state: Vector) -> Matrix:
    """Return what stands left of Phi in equation (1), for the state just before the event, (n_x, n_x)."""
    where = (clock, state, domain.parameters)
    guard_x, guard_t = slopes(leaving.guard, f"the guard of '{leaving.name}'", *where)
    reset_x, reset_t = slopes(leaving.reset, f"the reset of '{leaving.name}'", *where)
    rate = np.asarray(domain.field(*where).full()).reshape(-1)
    crossing = float((guard_x @ rate + guard_t).item())
    if abs(crossing) < GRAZING * (np.linalg.norm(guard_x) * np.linalg.norm(rate) + abs(guard_t.item())):
        raise WorkError(f"the orbit only grazes the guard of '{leaving.name}', so its Poincare map has no derivative")
    return reset_x - np.outer(reset_x @ rate + reset_t, guard_x) / crossing
