"""The closed loop of a gait under a torque law with free gains: what is ``weight_search`` for output weights.

On the orbit the torques of feedback vanish whatever the gains are, so the orbit, its events and the slopes of its
resets stay, and one gain changes the slope of the field by [0; G d^2 u / (dp dx)] alone, G the response of the
accelerations to the torques: of rank one for the gain of one joint (docs/theory/impedance.md, eq. 7).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import casadi as ca
import numpy as np

from amble.errors import InputError, WorkError
from amble.gait import Feedback, Gait
from amble.gait.closed_loop import symmetries
from amble.gait.control_law import Numbers, TorqueLaw
from amble.robot.natural_units import natural_units
from amble.stability.closed_loop_orbit import closed_loop_fixed_point, own_feedback
from amble.stability.collocation import fundamental
from amble.stability.lyapunov import smoothed_radius
from amble.stability.orbit import RULE, Orbit, sample_orbit
from amble.stability.weight_search import LARGEST_DRIFT, TRACE, Closed, passages_of, radius_and_bound
from amble.stability.weighted_map import Transport, around, forced_event, reduced, sandwiched
from amble.types import Matrix, NodeValues, Vector

if TYPE_CHECKING:
    from amble.hybrid import HybridSystem
    from amble.stability.fixed_point import FixedPoint

LARGEST_CHANGE, STIFFER_DAMPING = float(np.log(4.0)), float(np.log(1.5))
"""Gains stay within the first factor of where they start, either way, as a logarithm; dampings rise by the second at
most, since the fastest mode of a leg in the air goes with them (docs/theory/impedance.md, eq. 6)."""


@dataclass(frozen=True, kw_only=True)
class GainMap:
    """The Poincare Jacobian on the orbit's basis for one choice of gains, and what its gradient needs.

    Attributes:
        matrices: (m, m), one for every order of landing.
        search: the gait with its orbit.
        values: the gains, (size,).
        packed: solved domain -> p with these gains.
        transports: one a domain.
    """

    matrices: tuple[Matrix, ...]
    search: GainSearch
    values: Vector
    packed: Mapping[str, Vector]
    transports: tuple[Transport, ...]

    def gradient(self, outers: Sequence[Matrix]) -> Vector:
        """Return the gradient in the logarithms of the gains of a function with these slopes in ``matrices``."""
        found, orbit = np.zeros(self.values.size), self.search.orbit
        sides = around(orbit, self.transports, outers)
        for domain, transport, (rows, jumps) in zip(orbit.domains, self.transports, sides, strict=True):
            before, after = sandwiched(transport, rows, jumps)
            weights = (before @ after).transpose(0, 2, 1)
            pulled = self.search.pulled(domain.name, self.packed[domain.name], weights)
            for label, place in self.search.places[domain.name].items():
                found[self.search.labels.index(label)] += pulled[place]
        return found * self.values

    def conditioning(self) -> tuple[float, Vector]:
        """What a change of the gains costs: the sum of squares of its logarithms; torques need no decoupling."""
        start = self.search.values(np.zeros(self.values.size))
        theta: Vector = np.log(self.values / start)
        return float(theta @ theta), 2.0 * theta


@dataclass(frozen=True, kw_only=True)
class GainSearch:
    """A gait under a torque law with free gains; theta are the logarithms of the gains over where they start.

    Attributes:
        gait: the gait, with feedback on its own orbit.
        law: its control law, with the gains of theta = 0.
        places: solved domain -> label of a gain -> place in p.
        packed: solved domain -> p at theta = 0.
        orbit: the orbit.
    """

    gait: Gait
    law: TorqueLaw
    places: Mapping[str, Mapping[str, int]]
    packed: Mapping[str, Vector]
    orbit: Orbit

    @classmethod
    def of(cls, gait: Gait) -> GainSearch:
        """Start at the gains of the gait's control law.

        Raises:
            InputError: the law has no positive gains that could be chosen.
            FallError, NotSolvedError: the closed loop has no orbit near the gait.
        """
        law = gait.control
        if not isinstance(law, TorqueLaw):
            raise InputError("the gait's control law gives no torques, so it has no gains that could be chosen")
        whole = gait if gait.feedback is not None else replace(gait, feedback=own_feedback(gait))
        numbers = dict(zip((stance.name for stance in gait.pattern.solved), law.numbers(whole, None), strict=True))
        places = {
            name: {label: place for label, place in law.gains(whole, name).items() if entry.parameters[place] > 0.0}
            for name, entry in numbers.items()
        }
        if not any(places.values()):
            raise InputError(f"control law '{law.name}' has no positive gains that could be chosen")
        packed = {name: entry.parameters for name, entry in numbers.items()}
        system, found = closed_loop_fixed_point(whole, one_order=True)
        feedback: Feedback | None = whole.feedback and replace(whole.feedback, start=np.array(found.state))
        whole = replace(whole, feedback=feedback)
        orbit = _sampled(whole, law, tuple(numbers.values()), system, found)
        return cls(gait=whole, law=law, places=places, packed=packed, orbit=orbit)

    @property
    def labels(self) -> tuple[str, ...]:
        """The free gains."""
        return tuple(dict.fromkeys(label for domain in self.places.values() for label in domain))

    @property
    def size(self) -> int:
        """Number of free gains."""
        return len(self.labels)

    @property
    def bounds(self) -> list[tuple[float, float]]:
        """Of theta, least and largest."""
        rises = [STIFFER_DAMPING if label.endswith("damping") else LARGEST_CHANGE for label in self.labels]
        return [(-LARGEST_CHANGE, rise) for rise in rises]

    def values(self, theta: Vector) -> Vector:
        """Return the gains, in the order of ``labels``."""
        start = {
            label: self.packed[name][place] for name, places in self.places.items() for label, place in places.items()
        }
        return np.array([start[label] for label in self.labels]) * np.exp(theta)

    def evaluate(self, theta: Vector) -> GainMap:
        """Evaluate the return map's Jacobian on the stored orbit."""
        values, packed = self.values(theta), {}
        for name, places in self.places.items():
            packed[name] = np.array(self.packed[name])
            for label, place in places.items():
                packed[name][place] = values[self.labels.index(label)]
        transports = tuple(_transport(domain.name, self.orbit, packed[domain.name]) for domain in self.orbit.domains)
        matrices = reduced(self.orbit, transports)
        return GainMap(matrices=matrices, search=self, values=values, packed=packed, transports=transports)

    def pulled(self, domain: str, packed: Vector, weights: NodeValues) -> Vector:
        """Return the gradient in p of the sum over all nodes of the weights (k, n_joints, n_x) times du/dx."""
        pattern = self.gait.pattern
        contacts, size = pattern.contacts(pattern.stance(domain)), self.gait.robot.size
        t, x, p = ca.SX.sym("t"), ca.SX.sym("x", 2 * size), ca.SX.sym("p", packed.size)
        outer = ca.SX.sym("outer", weights.shape[1], weights.shape[2])
        u = self.law.torques(contacts, t, x[:size], x[size:], p)
        slope = ca.gradient(ca.sum2(ca.sum1(outer * ca.jacobian(u, x))), p)
        function = ca.Function("pulled", [t, x, p, outer], [ca.densify(slope)])
        here = next(entry for entry in self.orbit.domains if entry.name == domain)
        count = len(weights)
        clock, states = here.clock.ravel(), here.states.reshape(-1, here.states.shape[-1])
        if here.lift_off is not None:
            clock, states = np.append(clock, here.duration), np.vstack([states, here.lift_off.state])
        stacked = np.concatenate(list(weights), axis=1)
        found = function.map(count)(clock[None], states.T, np.tile(packed[:, None], count), stacked)
        return np.asarray(ca.DM(found)).sum(axis=1)

    def close(self, theta: Vector) -> Closed:
        """Find the closed loop's own fixed point with other gains, and its radius and bound there.

        Raises:
            FallError, NotSolvedError: there is none.
            WorkError: it is another gait's.
        """
        values = dict(zip(self.labels, map(float, self.values(theta)), strict=True))
        gait = replace(self.gait, control=self.law.with_gains(values)) if np.any(theta) else self.gait
        feedback = gait.feedback
        if feedback is None:
            raise InputError("a gait without feedback has no orbit of its own to be stabilised")
        system, found = closed_loop_fixed_point(gait, one_order=True)
        drift = float(np.abs(found.state - feedback.start)[2:].max())
        if drift > LARGEST_DRIFT:
            raise WorkError(f"new gains moved the orbit by {drift:.2g}; at most {LARGEST_DRIFT:g} is allowed")
        passages = passages_of(gait, system, found)
        radius, bound = radius_and_bound(self.orbit, passages, gait.pattern.mirrored)
        return Closed(
            theta=theta,
            gait=replace(gait, feedback=replace(feedback, start=np.array(found.state))),
            passages=passages,
            found=found,
            radius=radius,
            bound=bound,
            drift=drift,
        )

    def radius(self, theta: Vector) -> float:
        """Return the spectral radius of a gait cycle on the stored orbit, the largest of all orders of landing."""
        sizes = [float(np.abs(np.linalg.eigvals(matrix)).max()) for matrix in self.evaluate(theta).matrices]
        return max(sizes) ** (2 if self.gait.pattern.mirrored else 1)

    def pulls(self, theta: Vector) -> dict[str, float]:
        """Return by how much every gain would change log r: label -> size of the slope."""
        here = self.evaluate(theta)
        slope = here.gradient([smoothed_radius(one, TRACE).slope / len(here.matrices) for one in here.matrices])
        return dict(zip(self.labels, map(float, np.abs(slope)), strict=True))


def _transport(name: str, orbit: Orbit, packed: Vector) -> Transport:
    domain = next(entry for entry in orbit.domains if entry.name == name)
    jacobian, response = domain.along(packed)
    identity, left = np.eye(jacobian.shape[-1]), domain.lift_off
    return Transport(
        solution=fundamental(RULE, domain.duration, jacobian),
        response=response,
        error=np.broadcast_to(identity, jacobian.shape),
        lift_off=None if left is None else forced_event(domain, left, packed, identity),
    )


def _sampled(
    gait: Gait, law: TorqueLaw, numbers: tuple[Numbers, ...], system: HybridSystem, found: FixedPoint
) -> Orbit:
    names = [stance.name for stance in gait.pattern.solved]
    loops = dict(zip(names, law.loops(gait, None, numbers), strict=True))
    turns = [item.generator(found.state) for item in symmetries(gait, law) if item.name == "yaw"]
    return sample_orbit(
        passages_of(gait, system, found),
        found.state,
        loops,
        natural_units(gait.robot, float(found.state[gait.robot.coordinate_index("z")])),
        [np.asarray(turn).ravel() for turn in turns],
        gait.robot.base.horizontal,
    )
