"""A closed orbit with everything its monodromy needs, so that new output weights need no new integration of the motion.

On the orbit the outputs and their rates vanish whatever the weights are, so the orbit, its events and the slopes of
its resets stay; only the slope of the vector field depends on the weights (docs/theory/virtual-constraints.md, eq. 18).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.polynomial import legendre

from amble.control.closed_loop import StanceLoop
from amble.hybrid import HybridSystem
from amble.stability.monodromy import event_factor
from amble.types import Matrix, NodeValues, Vector

PANELS = 12
STAGES = 5
"""Gauss-Legendre collocation: 12 panels of order 10 a domain reproduce the adaptive monodromy to about 1e-9."""


@dataclass(frozen=True)
class GaussRule:
    """Gauss-Legendre collocation on [0, 1]: nodes (s,), quadrature weights (s,), Butcher matrix (s, s)."""

    nodes: Vector
    weights: Vector
    integration: Matrix

    @classmethod
    def of(cls, stages: int) -> GaussRule:
        """Build the rule with s nodes, of order 2 s."""
        roots, halves = legendre.leggauss(stages)
        nodes = 0.5 * (roots + 1.0)
        powers = np.arange(1, stages + 1)
        integration = (nodes[:, None] ** powers / powers) @ np.linalg.inv(nodes[:, None] ** (powers - 1))
        return cls(nodes, 0.5 * halves, integration)


@dataclass(frozen=True, kw_only=True)
class DomainOrbit:
    """The orbit in one domain.

    Attributes:
        name: the domain.
        duration: s.
        clock: at the panels' Gauss nodes, (panels, stages), s.
        states: there, (panels, stages, n_x).
        event: slope of the state after the reset with respect to the state before the event at fixed clock,
            (n_x, n_x).
        variation: compiled (t, x, p) -> (d field / d x, R, E) of ``control.closed_loop.StanceLoop``.
    """

    name: str
    duration: float
    clock: Matrix
    states: NodeValues
    event: Matrix
    variation: ca.Function


@dataclass(frozen=True)
class Orbit:
    """A closed orbit.

    Attributes:
        domains: in order of the cycle.
        start: fixed point of the Poincare map, (n_x,).
        basis: columns spanning the image of the last event, less horizontal position and other neutral directions,
            orthonormal where every state is counted in its unit, (n_x, m): every state after the reset lies in it, so
            the multipliers of the map are those of dual A basis.
        dual: the left inverse of basis that takes a state to its coordinates, (m, n_x).
    """

    domains: tuple[DomainOrbit, ...]
    start: Vector
    basis: Matrix
    dual: Matrix


def sample_orbit(
    system: HybridSystem,
    start: Vector,
    loops: Mapping[str, StanceLoop],
    durations: Mapping[str, float],
    units: Vector,
    neutral: Sequence[Vector] = (),
) -> Orbit:
    """Sample the orbit that starts at a fixed point of a system with the given durations.

    Args:
        system: the closed loop whose cycle is the map under study.
        start: the fixed point, (n_x,).
        loops: domain -> its compiled functions.
        durations: domain -> duration on the orbit, s.
        units: how large a change of each state counts as one, (n_x,).
        neutral: directions at the start, beside horizontal position, in which every point is on the same orbit, (n_x,).
    """
    from scipy.integrate import solve_ivp

    rule = GaussRule.of(STAGES)
    domains, entry = [], np.asarray(start, dtype=np.float64)
    for domain, transition in system.cycle():
        duration = durations[domain.name]
        clock = duration * (np.arange(PANELS)[:, None] + rule.nodes) / PANELS

        def rate(t: float, x: Vector, field: ca.Function = domain.field, p: Vector = domain.parameters) -> Vector:
            return np.asarray(field(t, x, p)).ravel()

        motion = solve_ivp(
            rate, (0.0, duration), entry, "DOP853", np.append(clock.ravel(), duration), rtol=1e-12, atol=1e-12
        )
        before = motion.y[:, -1]
        event = event_factor(domain, transition, duration, before)
        states = motion.y[:, :-1].T.reshape(PANELS, STAGES, entry.size)
        domains.append(
            DomainOrbit(
                name=domain.name,
                duration=duration,
                clock=clock,
                states=states,
                event=event,
                variation=loops[domain.name].variation,
            )
        )
        entry = np.asarray(transition.reset(duration, before, domain.parameters)).ravel()
    image = _image(domains[-1].event / units[:, None], [direction / units for direction in neutral])
    return Orbit(tuple(domains), np.asarray(start), units[:, None] * image, image.T / units)


def _image(event: Matrix, neutral: Sequence[Vector]) -> Matrix:
    """Orthonormal basis of the image of an event, horizontal position and neutral directions left out."""
    kept = event.copy()
    kept[:2] = 0.0
    left, sizes, _ = np.linalg.svd(kept)
    basis: Matrix = left[:, sizes > 1e-9 * sizes[0]]
    for direction in neutral:
        along = basis.T @ np.where(np.arange(direction.size) < 2, 0.0, direction)
        basis = basis @ np.linalg.svd(along[:, None])[0][:, 1:]
    return basis
