"""A closed orbit with everything its monodromy needs, so that new output weights need no new integration of the motion.

On the orbit the outputs and their rates vanish whatever the weights are, so the orbit, its events and the slopes of
its resets stay; only the slope of the vector field depends on the weights (docs/theory/virtual-constraints.md, eq. 18),
and that of a guard that is a force, since feedback acts on the forces.
"""

from __future__ import annotations

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import casadi as ca
import numpy as np

from amble.control.closed_loop import StanceLoop
from amble.hybrid import Domain, HybridSystem, Transition
from amble.hybrid.system import numeric
from amble.simulation.bound import Bound, bind
from amble.stability.collocation import GaussRule, fundamental
from amble.stability.derivatives import slopes
from amble.stability.monodromy import Monodromy, event_factor
from amble.types import Matrix, NodeValues, Vector

RULE = GaussRule.of(5)

PANELS, AGREES = (4, 6, 8, 12, 16, 24), 1e-7
"""Numbers of panels that are tried in a domain: as few as reproduce the adaptive derivative to this share of it."""


@dataclass(frozen=True, kw_only=True)
class LiftOff:
    """An event whose guard is a force: its slope g_x depends on the feedback, and the event is reset - jump g_x.

    Attributes:
        state: just before it, (n_x,).
        reset: slope of the reset, (n_x, n_x).
        jump: what the state after it changes by with the time of the event, over the rate of the force, (n_x,).
        guard: (t, x, p) -> g.
        push: (t, x, p) -> what g changes by with that which feedback acts through (``StanceLoop.push``), (1, n).
    """

    state: Vector
    reset: Matrix
    jump: Vector
    guard: ca.Function
    push: ca.Function

    def factor(self, clock: float, parameters: Vector) -> Matrix:
        """Return the event for the parameters of a feedback, (n_x, n_x)."""
        slope, _ = slopes(self.guard, "the guard of a lift-off", clock, self.state, parameters)
        return self.reset - np.outer(self.jump, slope)


@dataclass(frozen=True, kw_only=True)
class DomainOrbit:
    """The orbit in one domain.

    Attributes:
        name: the domain.
        duration: s.
        clock: at the panels' Gauss nodes, (panels, stages), s.
        states: there, (panels, stages, n_x).
        event: slope of the state after the reset with respect to the state before the event at fixed clock,
            (n_x, n_x); where feet land one by one, of that after the last landing.
        variation: compiled (t, x, p) -> (d field / d x, R, E) of ``control.closed_loop.StanceLoop``.
        lift_off: the event where its guard is a force; None where it is a gap.
    """

    name: str
    duration: float
    clock: Matrix
    states: NodeValues
    event: Matrix
    variation: ca.Function
    lift_off: LiftOff | None = None

    def along(self, parameters: Vector) -> list[NodeValues]:
        """Return the results of ``variation`` at all Gauss nodes under some feedback, (k, rows, columns) each."""
        self._bound.parameters[:] = parameters
        count, size = self.clock.size, self.states.shape[-1]
        found = self._bound.along(self.clock.ravel(), self.states.reshape(count, size))
        return [
            flat.reshape(count, *reversed(self.variation.size_out(number))).transpose(0, 2, 1)
            for number, flat in enumerate(found)
        ]

    @functools.cached_property
    def _bound(self) -> Bound:
        return bind(self.variation, np.zeros(self.variation.numel_in(2)))


@dataclass(frozen=True, kw_only=True)
class Orbit:
    """A closed orbit.

    Attributes:
        domains: in order of the cycle.
        start: fixed point of the Poincare map, (n_x,).
        basis: columns spanning the image of the last event, less horizontal position and other neutral directions,
            orthonormal where every state is counted in its unit, (n_x, m): every state after the reset lies in it, so
            the multipliers of the map are those of dual A basis.
        dual: the left inverse of basis that takes a state to its coordinates, (m, n_x).
        events: of all domains, for every order in which feet may land; the first are those of ``domains``.
    """

    domains: tuple[DomainOrbit, ...]
    start: Vector
    basis: Matrix
    dual: Matrix
    events: tuple[tuple[Matrix, ...], ...]


def sample_orbit(
    passages: Sequence[tuple[HybridSystem, Monodromy]],
    start: Vector,
    loops: Mapping[str, StanceLoop],
    units: Vector,
    neutral: Sequence[Vector] = (),
    horizontal: int = 2,
) -> Orbit:
    """Sample the orbit that starts at a fixed point.

    Args:
        passages: the closed loop whose cycle is the map under study, and the derivative at the fixed point: one, or one
            for every order of landing.
        start: the fixed point, (n_x,).
        loops: solved domain -> its compiled functions.
        units: how large a change of each state counts as one, (n_x,).
        neutral: directions at the start, beside horizontal position, in which every point is on the same orbit, (n_x,).
        horizontal: how many of the first states are the horizontal position.
    """
    sampled = [_sampled(system, passage, np.asarray(start, dtype=np.float64), loops) for system, passage in passages]
    events = tuple(tuple(domain.event for domain in domains) for domains in sampled)
    last = np.hstack([order[-1] / units[:, None] for order in events])
    image = _image(last, [direction / units for direction in neutral], horizontal)
    return Orbit(
        domains=tuple(sampled[0]),
        start=np.asarray(start),
        basis=units[:, None] * image,
        dual=image.T / units,
        events=events,
    )


def _sampled(
    system: HybridSystem, passage: Monodromy, start: Vector, loops: Mapping[str, StanceLoop]
) -> list[DomainOrbit]:
    """Follow the arcs of a cycle; those between landings, which last no time, belong to the event before them."""
    leaving = {transition.name: transition for transition in system.transitions}
    domains, entry = list[DomainOrbit](), start
    for name, duration, factor in zip(passage.transitions, passage.durations, passage.factors, strict=True):
        transition = leaving[name]
        domain = system.domain(transition.source)
        if domain.name in loops:
            found, before = _followed(domain, transition, entry, loops[domain.name], (duration, factor))
            domains.append(found)
        else:
            domains[-1] = replace(domains[-1], event=factor @ domains[-1].event)
            before = entry + duration * numeric(domain.field(0.0, entry, domain.parameters))
        entry = numeric(transition.reset(duration, before, domain.parameters))
    return domains


def _followed(
    domain: Domain, transition: Transition, entry: Vector, loop: StanceLoop, known: tuple[float, Matrix]
) -> tuple[DomainOrbit, Vector]:
    """Sample one domain, of which duration and derivative are known; returns also the state before its event."""
    from scipy.integrate import solve_ivp

    (duration, factor), field = known, bind(domain.field, domain.parameters)
    motion = solve_ivp(
        lambda t, x: field(t, x)[0], (0.0, duration), entry, "DOP853", dense_output=True, rtol=1e-12, atol=1e-12
    )
    before = motion.y[:, -1]
    event = event_factor(domain, transition, duration, before)
    for panels in PANELS:
        clock = duration * (np.arange(panels)[:, None] + RULE.nodes) / panels
        orbit = DomainOrbit(
            name=domain.name,
            duration=duration,
            clock=clock,
            states=motion.sol(clock.ravel()).T.reshape(*clock.shape, entry.size),
            event=event,
            variation=loop.variation,
            lift_off=None if loop.push is None else _lift_off(domain, transition, duration, before, loop.push),
        )
        whole = fundamental(RULE, duration, orbit.along(domain.parameters)[0]).whole
        if np.linalg.norm(event @ whole - factor) <= AGREES * np.linalg.norm(factor):
            break
    return orbit, before


def _lift_off(domain: Domain, transition: Transition, clock: float, state: Vector, push: ca.Function) -> LiftOff:
    """Take the event of ``monodromy.event_factor`` apart."""
    where = (clock, state, domain.parameters)
    guard_x, guard_t = slopes(transition.guard, f"the guard of '{transition.name}'", *where)
    reset_x, reset_t = slopes(transition.reset, f"the reset of '{transition.name}'", *where)
    rate = numeric(domain.field(*where))
    jump = (reset_x @ rate + reset_t) / float((guard_x @ rate + guard_t).item())
    return LiftOff(state=state, reset=reset_x, jump=jump, guard=transition.guard, push=push)


def _image(event: Matrix, neutral: Sequence[Vector], horizontal: int) -> Matrix:
    """Orthonormal basis of the image of an event, horizontal position and neutral directions left out."""
    kept = event.copy()
    kept[:horizontal] = 0.0
    left, sizes, _ = np.linalg.svd(kept)
    basis: Matrix = left[:, sizes > 1e-9 * sizes[0]]
    for direction in neutral:
        along = basis.T @ np.where(np.arange(direction.size) < horizontal, 0.0, direction)
        basis = basis @ np.linalg.svd(along[:, None])[0][:, 1:]
    return basis
