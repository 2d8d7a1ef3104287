"""The Poincare Jacobian as a function of the output weights, with its exact gradient."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from amble.control.virtual_constraints import repacked
from amble.stability.collocation import Fundamental, fundamental
from amble.stability.orbit import RULE, DomainOrbit, LiftOff, Orbit
from amble.types import Matrix, NodeValues, Vector


@dataclass(frozen=True)
class Weighting:
    """Which weights are free, and where the analysis starts.

    Attributes:
        start: domain -> H_0, (n_y, n_a).
        free: domain -> mask of the free entries of H, (n_y, n_a).
        packed: domain -> parameters of the compiled loop with H_0.
        sizes: domain -> unit of every entry of H, (n_y, n_a), as the coordinates' natural units make it: 1 of angles.
        by_time: whether the curves run on time alone.
    """

    start: Mapping[str, Matrix]
    free: Mapping[str, NDArray[np.bool_]]
    packed: Mapping[str, Vector]
    sizes: Mapping[str, Matrix]
    by_time: bool = True

    @property
    def size(self) -> int:
        """Number of free weights."""
        return int(sum(mask.sum() for mask in self.free.values()))

    def weights(self, theta: Vector) -> dict[str, Matrix]:
        """Return H of every domain for the deviations theta from H_0 in natural units, (size,)."""
        result, offset = {}, 0
        for name, mask in self.free.items():
            count = int(mask.sum())
            matrix = np.array(self.start[name])
            matrix[mask] += theta[offset : offset + count] * self.sizes[name][mask]
            result[name] = matrix
            offset += count
        return result

    def gather(self, slopes: Mapping[str, Matrix]) -> Vector:
        """Turn slopes with respect to H into those with respect to theta."""
        return np.concatenate([slopes[name][mask] * self.sizes[name][mask] for name, mask in self.free.items()])


@dataclass(frozen=True, kw_only=True)
class Transport:
    """What one domain does to deviations for given weights.

    Attributes:
        solution: fundamental solution Phi.
        response: K at the nodes, (k, n_q, n_y).
        error: E at the nodes, (k, n_a, n_x).
        lift_off: what the feedback makes of an event whose guard is a force; None where it is a gap.
        weights: H, (n_y, n_a); empty where feedback has none.
    """

    solution: Fundamental
    response: NodeValues
    error: NodeValues
    lift_off: ForcedEvent | None = None
    weights: Matrix = field(default_factory=lambda: np.empty((0, 0)))


@dataclass(frozen=True, kw_only=True)
class ForcedEvent:
    """A lift-off under some feedback, which acts at its one instant as it does all along the domain.

    Attributes:
        event: slope of the state after the reset with respect to that before it, (n_x, n_x).
        jump: as in ``LiftOff``, (n_x,).
        push: what the force changes by with every output's acceleration, or with every torque, (n_y,).
        error: E before the event, (n_a, n_x).
    """

    event: Matrix
    jump: Vector
    push: Vector
    error: Matrix


@dataclass(frozen=True)
class WeightedMap:
    """The Poincare Jacobian on the orbit's basis for one choice of weights, and what its gradient needs.

    Attributes:
        matrices: (m, m), one for every order of landing; the eigenvalues are the multipliers, less those of horizontal
            position.
        orbit: the orbit.
        weighting: the free weights.
        transports: one a domain.
    """

    matrices: tuple[Matrix, ...]
    orbit: Orbit
    weighting: Weighting
    transports: tuple[Transport, ...]

    @property
    def radius(self) -> float:
        """Largest spectral radius."""
        return max(float(np.abs(np.linalg.eigvals(matrix)).max()) for matrix in self.matrices)

    def gradient(self, outers: Sequence[Matrix]) -> Vector:
        """Return the gradient with respect to theta of a function with these slopes with respect to ``matrices``.

        On the orbit d field / d x changes by -K dH E, a matrix of rank one for one weight, so
        dPhi(T, 0) = - int Phi(T, t) [0; K] dH E Phi(t, 0) dt; the slope of a force that ends a domain changes alike.
        """
        slopes = {}
        sides = around(self.orbit, self.transports, outers)
        for domain, transport, (rows, jumps) in zip(self.orbit.domains, self.transports, sides, strict=True):
            before, after = sandwiched(transport, rows, jumps)
            columns = before.transpose(1, 0, 2).reshape(before.shape[1], -1)
            slopes[domain.name] = -(columns @ after.reshape(-1, after.shape[2])).T
        return self.weighting.gather(slopes)

    def conditioning(self) -> tuple[float, Vector]:
        """Return how near the outputs come to what no torque can decouple, and its gradient in theta.

        The oblique projector Q = S R takes the accelerations that are commanded to those that follow, along the kernel
        of H. Its norm is one over the sine of an angle, infinite where the decoupling is singular, and the same for all
        weights of one kernel. The value is the mean over the domains of log(mean |Q|^2 / n_y); dQ = S K dH (1 - Q).
        It is zero where the curves run on a phase of the state, whose closure is not in Q.
        """
        total, slopes = 0.0, {}
        for domain, transport in zip(self.orbit.domains, self.transports, strict=True):
            mask = self.weighting.free[domain.name]
            slopes[domain.name] = np.zeros(mask.shape)
            if not self.weighting.by_time:
                continue
            response = transport.response[:, -mask.shape[1] :, :]  # of y_a, the last coordinates
            follows = response @ transport.weights
            size = float(np.sum(follows**2))
            total += np.log(size / (len(follows) * mask.shape[0])) / len(self.transports)
            missing = np.eye(mask.shape[1]) - follows
            slope = np.sum(response.transpose(0, 2, 1) @ follows @ missing.transpose(0, 2, 1), axis=0)
            slopes[domain.name] = 2.0 / (size * len(self.transports)) * slope
        return total, self.weighting.gather(slopes)


def around(orbit: Orbit, transports: Sequence[Transport], outers: Sequence[Matrix]) -> list[tuple[Matrix, Matrix]]:
    """Return of every domain P, (n_x, n_x), with which trace(P dPhi) is the change of a function of the maps.

    With the map left E Phi right of an order of landing and the function's slope G in it P = right G^T left E, summed
    over the orders. The second matrix is the same without E: a change of E weighs so much.

    Args:
        orbit: the orbit.
        transports: one a domain.
        outers: slopes of the function in the maps of all orders, (m, m) each.
    """
    sides = [(np.zeros_like(t.solution.whole), np.zeros_like(t.solution.whole)) for t in transports]
    for events, outer in zip(orbit.events, outers, strict=True):
        happened = _happened(events, transports)
        factors = [event @ t.solution.whole for event, t in zip(happened, transports, strict=True)]
        lefts = [orbit.dual]
        for later in reversed(factors[1:]):
            lefts.append(lefts[-1] @ later)
        right = orbit.basis
        for event, factor, left, weighed in zip(happened, factors, reversed(lefts), sides, strict=True):
            share = right @ outer.T @ left
            weighed[0][:] += share @ event
            weighed[1][:] += share
            right = factor @ right
    return sides


def _happened(events: Sequence[Matrix], transports: Sequence[Transport]) -> list[Matrix]:
    """The events under the feedback of the transports."""
    return [event if t.lift_off is None else t.lift_off.event for event, t in zip(events, transports, strict=True)]


def reduced(orbit: Orbit, transports: Sequence[Transport]) -> tuple[Matrix, ...]:
    """Return the Poincare Jacobian on the orbit's basis, (m, m), in every order of landing."""
    matrices = []
    for events in orbit.events:
        total = orbit.basis
        for event, transport in zip(_happened(events, transports), transports, strict=True):
            total = event @ (transport.solution.whole @ total)
        matrices.append(orbit.dual @ total)
    return tuple(matrices)


def weighted_map(orbit: Orbit, weighting: Weighting, theta: Vector) -> WeightedMap:
    """Evaluate the Poincare Jacobian for given weights."""
    weights = weighting.weights(theta)
    transports = tuple(
        _transport(domain, weighting.packed[domain.name], weights[domain.name]) for domain in orbit.domains
    )
    return WeightedMap(reduced(orbit, transports), orbit, weighting, transports)


def _transport(domain: DomainOrbit, packed: Vector, weights: Matrix) -> Transport:
    parameters = repacked(packed, weights)
    inverse = np.asarray(np.linalg.pinv(weights), dtype=np.float64)
    jacobian, response, error = domain.along(parameters)
    forced = None
    if domain.lift_off is not None:
        before = domain.variation(domain.duration, domain.lift_off.state, parameters)[2]
        forced = forced_event(domain, domain.lift_off, parameters, np.asarray(before), inverse)
    return Transport(
        solution=fundamental(RULE, domain.duration, jacobian),
        response=response @ inverse,
        error=error,
        lift_off=forced,
        weights=weights,
    )


def forced_event(
    domain: DomainOrbit, lift_off: LiftOff, parameters: Vector, error: Matrix, inverse: Matrix | None = None
) -> ForcedEvent:
    """Return what a feedback makes of a lift-off.

    Args:
        domain: that it ends.
        lift_off: the event.
        parameters: p of the feedback.
        error: E before the event, (n_a, n_x).
        inverse: H^+ where the feedback acts through outputs, (n_a, n_y).
    """
    push = np.asarray(lift_off.push(domain.duration, lift_off.state, parameters)).ravel()
    return ForcedEvent(
        event=lift_off.factor(domain.duration, parameters),
        jump=lift_off.jump,
        push=push if inverse is None else push @ inverse,
        error=error,
    )


def sandwiched(transport: Transport, rows: Matrix, jumps: Matrix) -> tuple[NodeValues, NodeValues]:
    """Return B_k = E Phi(t_k, 0), (k, n_a, n_x), and A_k, (k, n_x, n_y), of one domain.

    Where feedback changes by dU_k, so that the field's lower rows change by K dU_k E, trace(rows dPhi + jumps dE) is
    sum_k trace(B_k A_k dU_k). A lift-off is one node more.

    Args:
        transport: of the domain.
        rows: P, as of ``around``.
        jumps: the same without the event.
    """
    before = transport.error @ transport.solution.until
    after = transport.solution.pulled(rows) @ transport.response
    forced = transport.lift_off
    if forced is None:
        return before, after
    last = forced.error @ transport.solution.whole, -np.outer(jumps @ forced.jump, forced.push)
    return np.concatenate([before, last[0][None]]), np.concatenate([after, last[1][None]])
