"""The Poincare Jacobian as a function of the output weights, with its exact gradient."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from amble.control.virtual_constraints import repacked
from amble.simulation.bound import bind
from amble.stability.orbit import PANELS, RULE, STAGES, DomainOrbit, LiftOff, Orbit
from amble.types import Matrix, NodeValues, Vector


@dataclass(frozen=True)
class Weighting:
    """Which weights are free, and where the analysis starts.

    Attributes:
        start: domain -> H_0, (n_y, n_a).
        free: domain -> mask of the free entries of H, (n_y, n_a).
        packed: domain -> parameters of the compiled loop with H_0.
        by_time: whether the curves run on time alone.
    """

    start: Mapping[str, Matrix]
    free: Mapping[str, NDArray[np.bool_]]
    packed: Mapping[str, Vector]
    by_time: bool = True

    @property
    def size(self) -> int:
        """Number of free weights."""
        return int(sum(mask.sum() for mask in self.free.values()))

    def weights(self, theta: Vector) -> dict[str, Matrix]:
        """Return H of every domain for the deviations theta from H_0, (size,)."""
        result, offset = {}, 0
        for name, mask in self.free.items():
            count = int(mask.sum())
            matrix = np.array(self.start[name])
            matrix[mask] += theta[offset : offset + count]
            result[name] = matrix
            offset += count
        return result

    def gather(self, slopes: Mapping[str, Matrix]) -> Vector:
        """Collect the free entries of matrices shaped like H, in the order of theta."""
        return np.concatenate([slopes[name][mask] for name, mask in self.free.items()])


@dataclass(frozen=True, kw_only=True)
class Transport:
    """Fundamental solutions of one domain for given weights.

    Attributes:
        whole: Phi(T, 0), (n_x, n_x).
        until: Phi(t_k, 0) at all Gauss nodes, (k, n_x, n_x).
        within: Phi from the beginning of every panel to its nodes, (panels, stages, n_x, n_x).
        across: Phi across every panel, (panels, n_x, n_x).
        response: K at the nodes, (k, n_q, n_y).
        error: E at the nodes, (k, n_a, n_x).
        measure: quadrature weights over time, (k,), s.
        lift_off: what the feedback makes of an event whose guard is a force; None where it is a gap.
        weights: H, (n_y, n_a); empty where feedback has none.
    """

    whole: Matrix
    until: NodeValues
    within: NodeValues
    across: NodeValues
    response: NodeValues
    error: NodeValues
    measure: Vector
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
        total = np.zeros(self.weighting.size)
        for events, outer in zip(self.orbit.events, outers, strict=True):
            collected = {}
            both = around(self.orbit, events, self.transports)
            for domain, sides, transport in zip(self.orbit.domains, both, self.transports, strict=True):
                before, after = sandwiched(*sides, transport)
                collected[domain.name] = -np.einsum("kmr,mn,kcn->rc", after, outer, before, optimize=True)
            total += self.weighting.gather(collected)
        return total

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
            size = float(np.einsum("kij,kij->", follows, follows))
            total += np.log(size / (len(follows) * mask.shape[0])) / len(self.transports)
            missing = np.eye(mask.shape[1]) - follows
            slope = np.einsum("kir,kij,kcj->rc", response, follows, missing, optimize=True)
            slopes[domain.name] = 2.0 / (size * len(self.transports)) * slope
        return total, self.weighting.gather(slopes)


def around(
    orbit: Orbit, events: Sequence[Matrix], transports: Sequence[Transport]
) -> list[tuple[Matrix, Matrix, Matrix]]:
    """Return what stands left of E_d Phi_d in the product dual E_D Phi_D ... E_1 Phi_1 basis, E_d, and what right."""
    happened = _happened(events, transports)
    factors = [event @ t.whole for event, t in zip(happened, transports, strict=True)]
    found = []
    for index, event in enumerate(happened):
        left, right = orbit.dual, orbit.basis
        for later in reversed(factors[index + 1 :]):
            left = left @ later
        for earlier in factors[:index]:
            right = earlier @ right
        found.append((left, event, right))
    return found


def _happened(events: Sequence[Matrix], transports: Sequence[Transport]) -> list[Matrix]:
    """The events under the feedback of the transports."""
    return [event if t.lift_off is None else t.lift_off.event for event, t in zip(events, transports, strict=True)]


def reduced(orbit: Orbit, transports: Sequence[Transport]) -> tuple[Matrix, ...]:
    """Return the Poincare Jacobian on the orbit's basis, (m, m), in every order of landing."""
    matrices = []
    for events in orbit.events:
        total = orbit.basis
        for event, transport in zip(_happened(events, transports), transports, strict=True):
            total = event @ (transport.whole @ total)
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
    jacobian, response, error = along_orbit(domain, parameters)
    found = replace(transported(domain, jacobian, response @ inverse, error), weights=weights)
    if domain.lift_off is None:
        return found
    before = domain.variation(domain.duration, domain.lift_off.state, parameters)[2]
    return replace(found, lift_off=forced_event(domain, domain.lift_off, parameters, np.asarray(before), inverse))


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


def along_orbit(domain: DomainOrbit, parameters: Vector) -> list[NodeValues]:
    """Return the results of ``DomainOrbit.variation`` at all Gauss nodes, (k, rows, columns) each."""
    size, count = domain.states.shape[-1], PANELS * STAGES
    found = bind(domain.variation, parameters).along(domain.clock.ravel(), domain.states.reshape(count, size))
    return [
        flat.reshape(count, *reversed(domain.variation.size_out(number))).transpose(0, 2, 1)
        for number, flat in enumerate(found)
    ]


def transported(domain: DomainOrbit, jacobian: NodeValues, response: NodeValues, error: NodeValues) -> Transport:
    """Solve Phi' = F(t) Phi by Gauss collocation, all panels at once; F is ``jacobian``, the rest goes along."""
    size, count = domain.states.shape[-1], PANELS * STAGES
    step = domain.duration / PANELS
    fields = jacobian.reshape(PANELS, STAGES, size, size)
    inner = _collocated(step, fields)
    across = np.eye(size) + step * np.einsum("s,psab,psbc->pac", RULE.weights, fields, inner, optimize=True)
    whole, until = np.eye(size), np.empty_like(inner)
    for panel in range(PANELS):
        until[panel] = inner[panel] @ whole
        whole = across[panel] @ whole
    return Transport(
        whole=whole,
        until=until.reshape(count, size, size),
        within=inner,
        across=across,
        response=response,
        error=error,
        measure=np.tile(step * RULE.weights, PANELS),
    )


def _collocated(step: float, fields: NodeValues) -> NodeValues:
    """Solve Z_i = 1 + h sum_j A_ij F_j Z_j in every panel, (panels, stages, n_x, n_x).

    The positions' rows of F are [0 1], so the velocities' rows of Z remain: with F_j = [0 1; L_j D_j]
    V_i - sum_j (h A_ij D_j + h^2 sum_k A_ik A_kj L_k) V_j = [0 1] + h sum_j A_ij L_j [1 0].
    """
    panels, stages, size, _ = fields.shape
    half, rule = size // 2, step * RULE.integration
    stiffness, damping = fields[:, :, half:, :half], fields[:, :, half:, half:]
    twice = np.einsum("ik,kj->ijk", rule, rule).reshape(-1, stages)  # over k, for every pair of stages
    blocks = (twice @ stiffness.reshape(panels, stages, -1)).reshape(panels, stages, stages, half, half)
    blocks += rule[:, :, None, None] * damping[:, None]
    system = np.eye(stages * half) - blocks.transpose(0, 1, 3, 2, 4).reshape(panels, stages * half, -1)
    right = np.zeros((panels, stages, half, size))
    right[..., :half] = (rule @ stiffness.reshape(panels, stages, -1)).reshape(stiffness.shape)
    right[..., half:] = np.eye(half)
    found = np.empty_like(fields)
    found[:, :, half:] = np.linalg.solve(system, right.reshape(panels, -1, size)).reshape(right.shape)
    found[:, :, :half] = np.eye(half, size) + (rule @ found[:, :, half:].reshape(panels, stages, -1)).reshape(
        right.shape
    )
    return found


def sandwiched(left: Matrix, event: Matrix, right: Matrix, transport: Transport) -> tuple[NodeValues, NodeValues]:
    """Return E Phi(t_k, 0) right, (k, n_a, m), and left E_d Phi(T, t_k) [0; K] times measure, (k, m, n_y).

    The sum of their products is minus the slope of the whole product in the weights. A lift-off is one node more.
    Phi(T, t_k) goes back panel by panel, so that modes that die out within a domain do no harm.
    """
    before = transport.error @ (transport.until @ right)
    half, size = transport.response.shape[1], transport.whole.shape[0]
    onward, rows = np.empty((PANELS, STAGES, *left.shape)), left @ event
    for panel in reversed(range(PANELS)):
        rows = rows @ transport.across[panel]
        backward = transport.within[panel].transpose(0, 2, 1)
        onward[panel] = np.linalg.solve(backward, np.broadcast_to(rows.T, (STAGES, *rows.T.shape))).transpose(0, 2, 1)
    after = onward.reshape(PANELS * STAGES, -1, size)[:, :, half:] @ transport.response
    after *= transport.measure[:, None, None]
    forced = transport.lift_off
    if forced is None:
        return before, after
    last = forced.error @ (transport.whole @ right), -np.outer(left @ forced.jump, forced.push)
    return np.concatenate([before, last[0][None]]), np.concatenate([after, last[1][None]])
