"""What a push on the base does to first order: to the next entry, and to the contact forces on the way there.

A push of impulse p begins at a phase, a share of the cycle. To first order its effect is linear in its horizontal
direction: two differences a phase give every direction. Two predictions of how large a push may be follow:

- by W: it moves the next entry by |b|_W per impulse, so the impulse that a gait takes goes as 1 / |b|_W;
- by contact: the impulse at which the first foot in contact would pull or leave its friction cone.

Both are linear; neither knows of steps that land elsewhere (docs/theory/robustness.md, section 6). Where feet land one
by one a difference is the mean of the two orders that the two pushes make.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.errors import FallError
from amble.gait.unilateral_state import Push, unilateral_start
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport, silent
from amble.robot import Robot
from amble.simulation import Trace, simulate
from amble.stability.input_gains import TIME_LIMIT, TOLERANCE, CycleMap
from amble.types import Matrix, NodeValues, Vector

IMPULSE = 1e-4
"""Of the pushes of the differences, in m sqrt(g l)."""

SHARE = 0.067
"""Duration of a push, in sqrt(l / g): 20 ms for ASTRo."""

CYCLES, SAMPLES = 2, 21

PHASES = 12

FAR = 1e9
"""Reserve of a foot that is not in contact, weights."""


def push_duration(robot: Robot) -> float:
    """Return how long a push lasts, s."""
    return SHARE * float(np.sqrt(robot.leg_length / robot.gravity))


def impulse_unit(robot: Robot) -> float:
    """Return m sqrt(g l), N s."""
    return float(robot.mass * np.sqrt(robot.gravity * robot.leg_length))


def push_of(robot: Robot, impulse: Vector, begin: float) -> Push:
    """Return a push of an impulse along x and y of the world, (2,), N s, that begins at a time, s."""
    lasting = push_duration(robot)
    return Push(force=(impulse[0] / lasting, impulse[1] / lasting, 0.0), begin=begin, end=begin + lasting)


@dataclass(frozen=True, kw_only=True)
class PushResponse:
    """The response to pushes that begin at some phases.

    Attributes:
        phases: shares of the cycle, (k,).
        entries: b per impulse along x and along y, in the basis of the spectrum, (k, 2, m), 1/(N s).
        reserves: of every contact and sample, (k, n), weights: normal force, then reserve of the cone.
        friction_used: largest friction that a foot uses on the way, without pushes.
        slopes: change of ``reserves`` per impulse, (k, 2, n), weights/(N s).
        cycle: what entries are measured by.
    """

    phases: Vector
    entries: Matrix
    reserves: Matrix
    friction_used: float
    slopes: Matrix
    cycle: CycleMap

    def by_metric(self, place: int, direction: float) -> float:
        """Return 1 / |b|_W of a push at a phase in a horizontal direction, rad from x to y; N s per unit of W."""
        x, y = self.entries[place]
        return 1.0 / self.cycle.weighted(np.cos(direction) * x + np.sin(direction) * y)

    def by_contact(self, place: int, direction: float) -> float:
        """Return the impulse at which the first contact is lost, to first order, N s; infinite where none is."""
        x, y = self.slopes[place]
        slope, reserve = np.cos(direction) * x + np.sin(direction) * y, self.reserves[place]
        losing = slope < 0.0
        return float(np.min(reserve[losing] / -slope[losing])) if losing.any() else float("inf")


def push_response(cycle: CycleMap, friction: float, progress: Progress | None = None) -> PushResponse:
    """Differentiate walks with a push that begins at ``PHASES`` phases, along x and y.

    Args:
        cycle: the gait.
        friction: of the ground whose cones are looked at; the feet of the model do not slip.
        progress: called with what is differentiated.

    Raises:
        FallError: a walk with a small push does not come back, or on other contacts than the orbit.
    """
    notify, robot = progress or silent, cycle.gait.robot
    period, phases = cycle.gait.period, (np.arange(PHASES) + 0.5) / PHASES
    unit = IMPULSE * impulse_unit(robot)
    system = cycle.walker
    nominal = _walked(cycle, system, Push())
    usual = _reserves(cycle, nominal, friction)
    entries, slopes = np.zeros((PHASES, 2, len(cycle.metric))), np.zeros((PHASES, 2, usual.size))
    for k, phase in enumerate(phases):
        notify(ProgressReport(what="response to a push, phase", done=k, of=PHASES))
        begin = float(phase * period)
        whole = 1 if begin + push_duration(robot) < period else 2
        for axis in range(2):
            traces = [
                _walked(cycle, system, push_of(robot, sign * unit * np.eye(2)[axis], begin)) for sign in (1.0, -1.0)
            ]
            moved = (traces[0].section[whole] - traces[1].section[whole])[: cycle.state.size] / (2.0 * unit)
            entries[k, axis] = cycle.reduced(moved)
            ahead, behind = (_reserves(cycle, trace, friction) for trace in traces)
            if not usual.shape == ahead.shape == behind.shape:
                raise FallError(
                    f"a push of {unit:.2g} N s at {phase:.2g} of the cycle changes which feet are let go or touch: on "
                    "ground that pushes only the orbit lies at the edge of its contacts and has no response to first "
                    "order; one whose feet stand and land with a reserve has ([limits] normal_force, standing_force)"
                )
            stands = np.max([usual, ahead, behind], axis=0) < FAR  # in other orders of landing others stand between
            slopes[k, axis] = np.where(stands, (ahead - behind) / (2.0 * unit), 0.0)
    return PushResponse(
        phases=phases,
        entries=entries,
        reserves=np.tile(usual, (PHASES, 1)),
        friction_used=_friction_used(cycle, nominal),
        slopes=slopes,
        cycle=cycle,
    )


def _walked(cycle: CycleMap, system: HybridSystem, push: Push) -> Trace:
    start = unilateral_start(cycle.gait, cycle.state, push)
    trace = simulate(system, start, CYCLES, TOLERANCE, SAMPLES, TIME_LIMIT)
    if not trace.completed:
        raise FallError(trace.ended)
    return trace


def _forces(cycle: CycleMap, trace: Trace) -> tuple[NodeValues, NodeValues]:
    """Normal force and tangential load of every foot at every sample, (n, n_feet), N."""
    pattern, rows = cycle.gait.pattern, len(trace.time)
    feet = len(pattern.robot.feet)
    force = trace.signals["force"].reshape(rows, feet, pattern.contact.size)
    local = pattern.contact.local(force, pattern.ground.frame(trace.signals["foot"].reshape(rows, feet, 3)))
    return pattern.contact.normal_force(local), pattern.contact.tangential(local)


def _reserves(cycle: CycleMap, trace: Trace, friction: float) -> Vector:
    """Normal force and reserve of the cone of every foot in contact at every sample, weights; far from 0 elsewhere."""
    robot, (normal, load) = cycle.gait.robot, _forces(cycle, trace)
    both = np.stack([normal, friction * normal - load]) / (robot.mass * robot.gravity)
    return np.where(trace.signals["contact"] > 0.5, both, FAR).ravel()


def _friction_used(cycle: CycleMap, trace: Trace) -> float:
    normal, load = _forces(cycle, trace)
    down = trace.signals["contact"] > 0.5
    return float(np.max(load[down] / normal[down]))
