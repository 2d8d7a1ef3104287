"""The closed loop of a gait with free output weights: its orbit, and what it is at its own fixed point under others.

The bilinear matrix inequality problem of orbital stabilisation is solved in the weights and W together.

The problem (Akbari Hamed et al. 2014; docs/theory/stability.md, eq. 20 to 24): find weights theta, W > 0 and the least
r with r^2 W - A(theta)^T W A(theta) > 0. It is bilinear in W and theta. With trace W bounded by c its best W for given
weights solves a Lyapunov equation, and r is the smoothed spectral radius (``lyapunov``): W is eliminated, and a smooth
function of the weights alone is left, with an exact gradient. No linear model in the weights and no semidefinite
program is needed. Where feet land one by one the map has a derivative for every order of landing, and the mean of their
log r is descended; whether one W serves all of them is then looked at (``common_bound``).
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np

from amble.control.closed_loop import StanceLoop, stance_loops
from amble.control.outputs import controllable
from amble.control.phase import TimePhase
from amble.errors import InputError, NotSolvedError, UnknownNameError, WorkError
from amble.gait import Feedback, Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.constraints import REFERENCE_ORDER, loop_parameters
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport
from amble.robot.natural_units import natural_units
from amble.stability.closed_loop_orbit import closed_loop_fixed_point, own_feedback
from amble.stability.common_bound import common_bound
from amble.stability.fixed_point import FixedPoint
from amble.stability.landing_orders import orders_of
from amble.stability.lyapunov import smoothed_radius
from amble.stability.monodromy import Monodromy, prepare_variational
from amble.stability.orbit import Orbit, sample_orbit
from amble.stability.weighted_map import WeightedMap, Weighting, weighted_map
from amble.types import Matrix, Vector

TRACE = 1e5
"""Bound c of trace W for states in natural units, so that no disturbance grows by more than sqrt(c)."""

SIZE_PENALTY = 1e-4
"""Weight of |theta|^2 beside log r: large weights amplify what the model leaves out."""

SIZE_PENALTY_IN_ORDERS = 1e-2
"""The same where feet land one by one: the model leaves out how long they stay apart. Of 400 starts of ASTRo's trot
changed by 1e-2 all come back, at a radius of 0.46; with 1e-4 nine of ten do, at 0.36."""

CONDITIONING = 0.1
"""Weight of ``conditioning`` beside log r: on the orbit nearly singular outputs cost nothing, beside it they end the
motion. Go2's bound came to |Q| = 2400, where no start 1e-5 beside it came back."""

CHEAPEST = 1e-3
"""Least of these weights: where the orbit would stay unstable, stabilisation goes on with a tenth of the last one."""

EVALUATIONS = 150
MEMORY = 30

LARGEST_DRIFT = 1e-3
"""What new weights may move the fixed point by: the references miss the orbit by about 1e-6, which weights feed back,
so that orbits under large weights lie up to 1e-5 away. More would be another gait."""


def size_penalty(price: float) -> float:
    """Return the weight of |theta|^2 where feet land one by one; it falls with the price of the conditioning."""
    return SIZE_PENALTY_IN_ORDERS * price / CONDITIONING


class ParametrisedMap(Protocol):
    """The Poincare Jacobian for some values of the free parameters, such as ``weighted_map.WeightedMap``."""

    @property
    def matrices(self) -> tuple[Matrix, ...]:
        """The Jacobian on the orbit's basis, (m, m), in every order of landing."""

    def gradient(self, outers: Sequence[Matrix]) -> Vector:
        """Return the gradient of a function with these slopes with respect to ``matrices``."""

    def conditioning(self) -> tuple[float, Vector]:
        """Return how near the feedback comes to what no torque can do, 0 where that is no matter, and its gradient."""


def least_bound(
    evaluate: Callable[[Vector], ParametrisedMap],
    theta: Vector,
    progress: Progress | None = None,
    bounds: Sequence[tuple[float, float]] | None = None,
    evaluations: int = EVALUATIONS,
    price: float = CONDITIONING,
) -> Vector:
    """Descend from theta to parameters of least bound r, by L-BFGS.

    Args:
        evaluate: what a choice of the parameters makes of the return map.
        theta: where to start.
        progress: called after every evaluation.
        bounds: of every parameter, least and largest; none by default.
        evaluations: of the return map, at most.
        price: weight of the conditioning beside log r.

    Raises:
        NotSolvedError: the return map of some parameters cannot be computed.
    """
    from scipy.optimize import minimize

    numbers = itertools.count(1)

    def objective(trial: Vector) -> tuple[float, Vector]:
        here = evaluate(trial)
        found = [smoothed_radius(matrix, TRACE) for matrix in here.matrices]
        mean = float(np.mean([np.log(one.value) for one in found]))
        if progress is not None:
            quantity = "contraction bound of the return map"
            progress(
                ProgressReport(
                    what="evaluation", done=next(numbers), of=evaluations, quantity=quantity, value=float(np.exp(mean))
                )
            )
        slope = here.gradient([one.slope / len(found) for one in found])
        penalty = SIZE_PENALTY if len(found) == 1 else size_penalty(price)
        strain, steeper = here.conditioning()
        slope += price * steeper + 2.0 * penalty * trial
        return mean + price * strain + penalty * float(trial @ trial), slope

    options = {"maxfun": evaluations, "maxcor": MEMORY}
    try:
        found = minimize(objective, theta, jac=True, method="L-BFGS-B", bounds=bounds, options=options)
        return np.asarray(found.x)
    except (InputError, np.linalg.LinAlgError) as error:
        raise NotSolvedError(f"no return map for the weights that the descent tried: {error}") from None


@dataclass(frozen=True, kw_only=True)
class Closed:
    """A closed loop under some weights, at its own fixed point.

    Attributes:
        theta: the weights, (size,).
        gait: the gait with these weights, starting at the fixed point.
        passages: its solved stances as a hybrid system with the derivative of its map, in every order of landing.
        found: the fixed point.
        radius: spectral radius of a whole gait cycle, the largest of all orders.
        bound: r of a whole gait cycle: V(x) = x^T W x falls by r^2 in it, trace W = ``TRACE``; of several
            orders that of the best common W.
        drift: how far the fixed point lies from that of theta = 0, largest component.
    """

    theta: Vector
    gait: Gait
    passages: tuple[tuple[HybridSystem, Monodromy], ...]
    found: FixedPoint
    radius: float
    bound: float
    drift: float

    def contracts(self, radius: float) -> bool:
        """Whether the spectral radius is at most one that is asked for, and one W serves all orders of landing."""
        return self.radius <= radius and (len(self.passages) == 1 or self.bound < 1.0)


@dataclass(frozen=True)
class WeightSearch:
    """A gait with free output weights, on the orbit of its closed loop under some of them.

    Attributes:
        gait: the gait.
        feedback: at theta = 0; its start is the fixed point there.
        weighting: the free weights.
        orbit: the orbit.
        price: weight of the conditioning in the descent.
    """

    gait: Gait
    feedback: Feedback
    weighting: Weighting
    orbit: Orbit
    price: float = CONDITIONING

    @property
    def size(self) -> int:
        """Number of free weights."""
        return self.weighting.size

    @classmethod
    def of(cls, gait: Gait, free: Sequence[str], weights: Mapping[str, Matrix] | None = None) -> WeightSearch:
        """Start at given weights, by default those of the gait problem; feedback that the gait has is replaced.

        Raises:
            UnknownNameError: a free coordinate does not exist.
            FallError, NotSolvedError: the closed loop has no orbit near the gait.
        """
        _require(gait, free)
        feedback = own_feedback(gait)
        feedback = feedback if weights is None else replace(feedback, weights=weights)
        whole = replace(gait, feedback=feedback)
        system, found = closed_loop_fixed_point(whole, one_order=True)
        feedback = replace(feedback, start=np.array(found.state))
        return cls(
            gait, feedback, _weighting(whole, feedback, free), _sampled(whole, passages_of(whole, system, found), found)
        )

    def evaluate(self, theta: Vector) -> WeightedMap:
        """Evaluate the return map's Jacobian on the stored orbit."""
        return weighted_map(self.orbit, self.weighting, theta)

    def gait_with(self, theta: Vector) -> Gait:
        """Return the gait with other weights, starting where it starts at theta = 0."""
        return replace(self.gait, feedback=self.feedback_with(theta))

    def close(self, theta: Vector) -> Closed:
        """Find the closed loop's own fixed point with other weights, and its radius and bound there.

        Raises:
            FallError, NotSolvedError: there is none.
            WorkError: it is another gait's.
        """
        gait = self.gait_with(theta)
        system, found = closed_loop_fixed_point(gait, one_order=True)
        drift = float(np.abs(found.state - self.feedback.start)[gait.robot.base.horizontal :].max())
        if drift > LARGEST_DRIFT:
            raise WorkError(f"new output weights moved the orbit by {drift:.2g}; at most {LARGEST_DRIFT:g} is allowed")
        passages = passages_of(gait, system, found)
        radius, bound = radius_and_bound(self.orbit, passages, gait.pattern.mirrored)
        return Closed(
            theta=theta,
            gait=replace(gait, feedback=replace(self.feedback_with(theta), start=np.array(found.state))),
            passages=passages,
            found=found,
            radius=radius,
            bound=bound,
            drift=drift,
        )

    def around(self, there: Closed) -> WeightSearch:
        """Go on from the orbit of a closed loop."""
        return replace(self, orbit=_sampled(there.gait, there.passages, there.found))

    def freeing(self, there: Closed, free: Sequence[str]) -> WeightSearch:
        """Go on from the weights of a closed loop, now theta = 0, with others free; drift counts from before."""
        feedback = self.feedback_with(there.theta)
        weighting = _weighting(replace(self.gait, feedback=feedback), feedback, free)
        orbit = _sampled(there.gait, there.passages, there.found)
        return replace(self, feedback=feedback, weighting=weighting, orbit=orbit)

    def feedback_with(self, theta: Vector) -> Feedback:
        """Return the feedback with other weights."""
        return replace(self.feedback, weights=self.weighting.weights(theta))

    def pulls(self, theta: Vector) -> dict[str, float]:
        """Return by how much a weight on each coordinate would change log r: coordinate -> norm of the slope."""
        names = controllable(self.gait.robot)
        whole = self.gait_with(theta)
        everything = _weighting(whole, self.feedback_with(theta), names)
        here = weighted_map(self.orbit, everything, np.zeros(everything.size))
        slope = here.gradient([smoothed_radius(one, TRACE).slope / len(here.matrices) for one in here.matrices])
        columns = np.concatenate([np.nonzero(mask)[1] for mask in everything.free.values()])
        return {name: float(np.linalg.norm(slope[columns == place])) for place, name in enumerate(names)}


def radius_and_bound(
    orbit: Orbit, passages: Sequence[tuple[HybridSystem, Monodromy]], mirrored: bool
) -> tuple[float, float]:
    """Return spectral radius and bound of a whole gait cycle, on the basis of an orbit; see ``Closed``."""
    matrices = [orbit.dual @ passage.matrix @ orbit.basis for _, passage in passages]
    several, power = len(matrices) > 1, 2 if mirrored else 1
    bound = common_bound(matrices).rate if several else smoothed_radius(matrices[0], TRACE).value
    return max(float(np.abs(np.linalg.eigvals(matrix)).max()) for matrix in matrices) ** power, bound**power


def passages_of(gait: Gait, system: HybridSystem, found: FixedPoint) -> tuple[tuple[HybridSystem, Monodromy], ...]:
    """The map of the solved stances in every order of landing; the system's own where there is one."""
    ordered = [closed_loop(gait, half=True, orders=order) for order in orders_of(gait)]
    if not ordered:
        return ((system, found.monodromy),)
    return tuple((one, prepare_variational(one)(found.state)) for one in ordered)


def _sampled(gait: Gait, passages: Sequence[tuple[HybridSystem, Monodromy]], found: FixedPoint) -> Orbit:
    height, base = float(found.state[gait.robot.coordinate_index("z")]), gait.robot.base
    units = natural_units(gait.robot, height)
    return sample_orbit(passages, found.state, _loops(gait), units, horizontal=base.horizontal)


def _loops(gait: Gait) -> dict[str, StanceLoop]:
    counts = [len(gait.outputs.of(stance.name).coordinates) for stance in gait.pattern.solved]
    loops = stance_loops(gait.pattern, gait.law, counts, REFERENCE_ORDER, gait.outputs.phase, gait.limits.normal_force)
    return dict(zip((stance.name for stance in gait.pattern.solved), loops, strict=True))


def _require(gait: Gait, free: Sequence[str]) -> None:
    names = controllable(gait.robot)
    for name in free:
        if name not in names:
            raise UnknownNameError("output coordinate", name, names)


def _weighting(gait: Gait, feedback: Feedback, free: Sequence[str]) -> Weighting:
    names = controllable(gait.robot)
    columns = [names.index(coordinate) for coordinate in free]
    units = dict(zip(gait.robot.coordinate_names, natural_units(gait.robot, gait.robot.leg_length), strict=False))
    masks, sizes = {}, {}
    for name, matrix in feedback.weights.items():
        sizes[name] = np.array([[units[y] / units[a] for a in names] for y in gait.outputs.of(name).coordinates])
        masks[name] = np.zeros(matrix.shape, dtype=np.bool_)
        masks[name][:, columns] = True
    packed = {name: loop_parameters(gait, name) for name in masks}
    return Weighting(dict(feedback.weights), masks, packed, sizes, by_time=isinstance(gait.outputs.phase, TimePhase))
