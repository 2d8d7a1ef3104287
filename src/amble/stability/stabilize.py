"""Exponential orbital stabilisation: choose output weights that make the orbit attractive, without moving it."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from amble.control.closed_loop import StanceLoop, stance_loops
from amble.control.outputs import controllable
from amble.errors import InputError, UnknownNameError, WorkError
from amble.gait import Gait
from amble.gait.closed_loop import REFERENCE_ORDER, loop_parameters
from amble.stability.bilinear import bilinear_step
from amble.stability.descent import descent_step, smooth_radius
from amble.stability.fixed_point import FixedPoint
from amble.stability.orbit import Orbit, sample_orbit
from amble.stability.own_orbit import own_fixed_point, with_own_orbit
from amble.stability.weighted_map import WeightedMap, Weighting, weighted_map
from amble.types import Vector

Method = Literal["bilinear", "descent"]
BASE = ("roll", "pitch", "yaw")
LONGEST_STEP, LARGEST_STEP = 1.0, 4.0
"""Length of the first step and what it may grow to: |d| for "bilinear", the share of the way for "descent"."""

SHORTEST_STEP = 1e-3
SMALLEST_GAIN = 2e-3
DESCENT_EVALUATIONS = 60
LARGEST_DRIFT = 1e-6
"""The fixed point may move this much under new weights; more means that the references do not reproduce the orbit."""


@dataclass(frozen=True)
class Step:
    """One accepted step, recomputed at the closed loop's own fixed point.

    Attributes:
        number: from 1; 0 is the start.
        radius: spectral radius of a whole gait cycle.
        length: |d| of the weights.
        drift: how far the fixed point moved since the start, largest component.
        seconds: wall time since the start.
    """

    number: int
    radius: float
    length: float
    drift: float
    seconds: float


@dataclass(frozen=True)
class Stabilized:
    """The result of a stabilisation.

    Attributes:
        gait: the gait with stabilised feedback.
        steps: the accepted steps, the first the start.
        reason: why it stopped.
        parameters: number of free weights.
        method: "bilinear" or "descent".
        seconds: wall time of everything, s.
    """

    gait: Gait
    steps: tuple[Step, ...]
    reason: str
    parameters: int
    method: str
    seconds: float

    @property
    def initial(self) -> float:
        """Spectral radius of a gait cycle before."""
        return self.steps[0].radius

    @property
    def radius(self) -> float:
        """Spectral radius of a gait cycle after."""
        return self.steps[-1].radius


Progress = Callable[[Step], None]
Doing = Callable[[str], None]


class NotStabilizedError(WorkError):
    """The orbit stays unstable; the message names the best radius and the outputs that limit it."""


def stabilize(
    gait: Gait,
    free: Sequence[str] = BASE,
    method: Method = "descent",
    target: float = 0.2,
    most_steps: int = 25,
    progress: Progress | None = None,
) -> Gait:
    """Return the gait with output weights that make its orbit exponentially stable; see ``stabilization``."""
    return stabilization(gait, free, method, target, most_steps, progress).gait


def stabilization(
    gait: Gait,
    free: Sequence[str] = BASE,
    method: Method = "descent",
    target: float = 0.2,
    most_steps: int = 25,
    progress: Progress | None = None,
    doing: Doing | None = None,
) -> Stabilized:
    """Stabilise a gait's orbit by weights on the outputs, y = H (y_a - y_d).

    Args:
        gait: the gait; feedback that it already has is replaced.
        free: coordinates among roll, pitch, yaw and the joints whose columns of H are free.
        method: "bilinear" iterates over linear matrix inequalities (the paper's way), "descent" descends the spectral
            radius itself.
        target: stop at this spectral radius of a whole gait cycle.
        most_steps: stop after so many steps.
        progress: called with every accepted step.
        doing: called between them with what is being computed, in words.

    Raises:
        UnknownNameError: a free coordinate or the method does not exist.
        InputError: the target is not between 0 and 1.
        NotStabilizedError: the radius stays at 1 or above; the message says why.
        FallError, NotSolvedError: the closed loop has no orbit near the gait.
    """
    _require(method, target)
    began = time.perf_counter()
    tell = doing or (lambda _: None)
    tell("orbit of the closed loop")
    search = _Search.of(with_own_orbit(gait), free, tell)
    theta, length = np.zeros(search.weighting.size), LONGEST_STEP
    steps = [search.accepted(0, theta, 0.0, began)]
    _tell(progress, steps[-1])
    reason = f"{most_steps} steps taken"
    while len(steps) <= most_steps and steps[-1].radius > target and length >= SHORTEST_STEP:
        try:
            proposed = search.propose(method, theta, length)
            if method == "descent" and not search.gains(theta, proposed):
                length = 0.0
                continue
            step = search.accepted(len(steps), proposed, float(np.linalg.norm(proposed - theta)), began)
        except WorkError as error:  # the closed loop fell, did not close, or the step's own problem failed: step back
            reason, length = str(error), 0.25 * length
            continue
        if step.radius >= steps[-1].radius * (1.0 - SMALLEST_GAIN):
            length *= 0.25
            continue
        steps.append(step)
        _tell(progress, step)
        theta, length = proposed, min(2.0 * length, LARGEST_STEP)
    if length < SHORTEST_STEP:
        reason = "no step reduces the radius any more"
    if steps[-1].radius <= target:
        reason = f"the target {target:g} is reached"
    if steps[-1].radius >= 1.0:
        raise NotStabilizedError(search.explain(theta, steps[-1].radius, free, reason))
    spent = time.perf_counter() - began
    return Stabilized(search.gait_with(theta), tuple(steps), reason, search.weighting.size, method, spent)


def _require(method: str, target: float) -> None:
    if method not in ("bilinear", "descent"):
        raise UnknownNameError("method", method, ["bilinear", "descent"])
    if not 0.0 < target < 1.0:
        raise InputError(f"the target radius is {target:g}; a stable orbit has a radius between 0 and 1")


@dataclass(frozen=True)
class _Search:
    """What stays fixed during a stabilisation."""

    gait: Gait
    orbit: Orbit
    weighting: Weighting
    power: int
    tell: Doing

    @classmethod
    def of(cls, gait: Gait, free: Sequence[str], tell: Doing) -> _Search:
        system, found = own_fixed_point(gait)
        durations = dict(zip((d.name for d in system.domains), found.monodromy.durations, strict=True))
        orbit = sample_orbit(system, found.state, _loops(gait), durations)
        return cls(gait, orbit, _weighting(gait, free), 2 if gait.pattern.mirrored else 1, tell)

    def evaluate(self, theta: Vector) -> WeightedMap:
        return weighted_map(self.orbit, self.weighting, theta)

    def propose(self, method: Method, theta: Vector, length: float) -> Vector:
        if method == "bilinear":
            self.tell("matrix inequalities")
            return theta + bilinear_step(self.evaluate(theta), length)[0]

        def show(number: int, radius: float) -> None:
            self.tell(f"evaluation {number} of {DESCENT_EVALUATIONS}, spectral radius {radius**self.power:.4g}")

        best = descent_step(self.orbit, self.weighting, theta, DESCENT_EVALUATIONS, show)
        return theta + min(length, 1.0) * (best - theta)

    def gains(self, theta: Vector, proposed: Vector) -> bool:
        """Whether the stored orbit promises a smaller radius; where it does not, a shorter step will not either."""
        return self.evaluate(proposed).radius < (1.0 - SMALLEST_GAIN) * self.evaluate(theta).radius

    def gait_with(self, theta: Vector) -> Gait:
        assert self.gait.feedback is not None
        return replace(self.gait, feedback=replace(self.gait.feedback, weights=self.weighting.weights(theta)))

    def accepted(self, number: int, theta: Vector, length: float, began: float) -> Step:
        """Find the fixed point of the closed loop with the new weights and take the radius there."""
        _, found = own_fixed_point(self.gait_with(theta))
        drift = float(np.abs(found.state - self.orbit.start)[2:].max())
        if drift > LARGEST_DRIFT:
            raise WorkError(f"new output weights moved the orbit by {drift:.2g}; the references do not reproduce it")
        return Step(number, self._radius(found) ** self.power, length, drift, time.perf_counter() - began)

    def _radius(self, found: FixedPoint) -> float:
        basis = self.orbit.basis
        return float(np.abs(np.linalg.eigvals(basis.T @ found.monodromy.matrix @ basis)).max())

    def explain(self, theta: Vector, radius: float, free: Sequence[str], reason: str) -> str:
        """Say which outputs limit the radius: by how much a weight on each coordinate would change it, best first."""
        names = controllable(self.gait.robot)
        everything = _weighting(self.gait_with(theta), names)
        here = weighted_map(self.orbit, everything, np.zeros(everything.size))
        pull = here.gradient(smooth_radius(here.matrix)[1])
        columns = np.concatenate([np.nonzero(mask)[1] for mask in everything.free.values()])
        effect = {name: float(np.linalg.norm(pull[columns == place])) for place, name in enumerate(names)}
        others = sorted((name for name in names if name not in free), key=lambda name: -effect[name])[:3]
        limiting = ", ".join(f"{name} ({effect[name]:.2g})" for name in free)
        helpful = ", ".join(f"{name} ({effect[name]:.2g})" for name in others)
        return (
            f"the orbit stays unstable: best spectral radius of a gait cycle {radius:.4g} ({reason}); "
            f"slope of its logarithm in the weights that were free: {limiting}; in those that were not: {helpful}"
        )


def _loops(gait: Gait) -> dict[str, StanceLoop]:
    counts = [len(gait.outputs.of(stance.name).coordinates) for stance in gait.pattern.solved]
    loops = stance_loops(gait.robot, gait.law, gait.pattern.switches, counts, REFERENCE_ORDER)
    return dict(zip((stance.name for stance in gait.pattern.solved), loops, strict=True))


def _weighting(gait: Gait, free: Sequence[str]) -> Weighting:
    names = controllable(gait.robot)
    for name in free:
        if name not in names:
            raise UnknownNameError("output coordinate", name, names)
    assert gait.feedback is not None
    start, packed, masks = dict(gait.feedback.weights), {}, {}
    for name, matrix in start.items():
        mask = np.zeros(matrix.shape, dtype=np.bool_)
        mask[:, [names.index(coordinate) for coordinate in free]] = True
        masks[name] = mask
        outputs, coordinates = matrix.shape
        packed[name] = loop_parameters(gait, name)[: -coordinates * (coordinates - outputs)]
    return Weighting(start, masks, packed)


def _tell(progress: Progress | None, step: Step) -> None:
    if progress is not None:
        progress(step)
