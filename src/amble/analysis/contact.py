"""Monitors of a simulated motion: unilateral contact, friction, penetration, drift, limits, rank.

Nothing is hidden: every monitored quantity becomes one row with its bounds, its worst value and when that occurred, and
the worst values of every cycle are kept, so that it can be said from which cycle on a motion is sound.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from amble.analysis.bounds import ContactBounds
from amble.analysis.samples import signal, stance_indices
from amble.gait import Gait
from amble.hybrid import GaitPattern
from amble.residual import Residual, worst_first
from amble.simulation import Trace
from amble.types import IntegerVector, NodeValues, Vector, frozen

Mask = NDArray[np.bool_]


@dataclass(frozen=True, kw_only=True)
class ContactReport:
    """What the monitors of a simulated motion saw.

    Attributes:
        min_normal_force: smallest normal force of a stance foot, N.
        max_friction: largest share of the cone that a stance foot uses, 1; infinite where a foot pulls.
        max_penetration: largest depth of a swing foot below the ground, m.
        max_drift: largest distance of a stance foot from where its stance phase began, m.
        max_landing_gap: largest distance from the ground, above or below it, of a landing foot that an impact stops, m.
        max_slip: largest speed of a stance foot, m/s.
        min_pivot: smallest pivot of the decoupling equations.
        pulls: samples in which some stance foot has no positive normal force.
        samples: number of samples that were looked at.
        rows: the worst value of every monitored quantity.
        normal_forces: smallest normal force of every cycle, (cycles,), N.
        frictions: largest friction used of every cycle, (cycles,), 1.
        penetrations: largest penetration of every cycle, (cycles,), m.
        drifts: largest drift of every cycle, (cycles,), m.
        landing_gaps: largest distance from the ground of a landing foot of every cycle, (cycles,), m.
        sound_from: the first cycle from which to the end every normal force is positive, friction stays in the cone
            and no foot pulls; None where the last cycle is not sound.
    """

    min_normal_force: float
    max_friction: float
    max_penetration: float
    max_drift: float
    max_landing_gap: float
    max_slip: float
    min_pivot: float
    pulls: int
    samples: int
    rows: tuple[Residual, ...]
    normal_forces: Vector
    frictions: Vector
    penetrations: Vector
    drifts: Vector
    landing_gaps: Vector
    sound_from: int | None

    @property
    def violations(self) -> tuple[Residual, ...]:
        """The rows outside their bounds, worst first."""
        return worst_first(row for row in self.rows if not row.passed)


@dataclass(frozen=True, kw_only=True)
class _Feet:
    """``QUANTITIES`` of every sample and foot, (n, n_feet); where one has no meaning it cannot win.

    The gap is the height of every foot, of stance feet too.
    """

    normal: NodeValues
    gap: NodeValues
    friction: NodeValues
    height: NodeValues
    drift: NodeValues
    slip: NodeValues
    pulls: Mask


def contact_report(trace: Trace, pattern: GaitPattern, bounds: ContactBounds) -> ContactReport:
    """Evaluate all monitors over a whole trace.

    Args:
        trace: a trace with the signals torque, force, foot, foot_velocity and pivot.
        pattern: the gait pattern that was simulated, with its ground.
        bounds: what the motion is held against.

    Raises:
        UnknownNameError: where the trace lacks a signal, or a domain is no stance of the pattern.
    """
    stances = stance_indices(trace, pattern)
    table = np.array([[foot in stance.feet for foot in pattern.robot.foot_names] for stance in pattern.visited])
    feet = _monitor_feet(trace, pattern, table[stances])
    starts = np.concatenate([[0], np.flatnonzero(np.diff(trace.cycle)) + 1])
    normal = np.minimum.reduceat(feet.normal.min(axis=1), starts)
    friction = np.maximum.reduceat(feet.friction.max(axis=1), starts)
    pulling = np.logical_or.reduceat(feet.pulls.any(axis=1), starts)
    penetration = np.maximum(0.0, -np.minimum.reduceat(feet.height.min(axis=1), starts))
    drift = np.maximum.reduceat(feet.drift.max(axis=1), starts)
    sound = (normal > 0.0) & (friction <= bounds.friction) & ~pulling
    landed = landings(trace, pattern, stances, feet.gap, bounds.touchdown)
    rows = [*_foot_rows(trace, pattern, stances, feet, bounds), *landed.rows, *_joint_rows(trace, pattern, bounds)]
    pivot = signal(trace, "pivot")[:, 0]
    rows.append(_worst("pivot of the decoupling equations", "pivot", pivot, (bounds.pivot, np.inf), trace, lowest=True))
    return ContactReport(
        min_normal_force=float(normal.min()),
        max_friction=float(friction.max()),
        max_penetration=float(penetration.max()),
        max_drift=float(drift.max()),
        max_landing_gap=float(landed.largest.max()),
        max_slip=float(feet.slip.max()),
        min_pivot=float(pivot.min()),
        pulls=int(np.sum(feet.pulls.any(axis=1))),
        samples=len(trace.time),
        rows=tuple(rows),
        normal_forces=frozen(normal),
        frictions=frozen(friction),
        penetrations=frozen(penetration),
        drifts=frozen(drift),
        landing_gaps=landed.largest,
        sound_from=_sound_from(sound, trace.cycle[starts]),
    )


def _monitor_feet(trace: Trace, pattern: GaitPattern, down: Mask) -> _Feet:
    """Evaluate the monitored quantities of all feet; ``down`` says which foot of which sample stands, (n, n_feet).

    A motion that has grown without bound has sizes whose squares are infinite, as they are told.
    """
    with np.errstate(over="ignore", invalid="ignore"):
        return _evaluated(trace, pattern, down)


def _evaluated(trace: Trace, pattern: GaitPattern, down: Mask) -> _Feet:
    ground, contact = pattern.ground, pattern.contact
    foot, velocity = (signal(trace, name).reshape((*down.shape, 3)) for name in ("foot", "foot_velocity"))
    speed = np.linalg.norm(velocity, axis=2)
    force = contact.local(signal(trace, "force").reshape((*down.shape, contact.size)), ground.frame(foot))
    normal, friction = contact.normal_force(force), contact.friction_used(force)
    drift = np.linalg.norm(foot - _where_phase_began(foot, down), axis=2)
    gap = ground.gap(foot)
    return _Feet(
        normal=np.where(down, normal, np.inf),
        friction=np.where(down, friction, 0.0),
        gap=gap,
        height=np.where(down, np.inf, gap),
        drift=np.where(down, drift, 0.0),
        slip=np.where(down, speed, 0.0),
        pulls=down & ~(normal > 0.0),
    )


def _where_phase_began(foot: NodeValues, down: Mask) -> NodeValues:
    """Position of every foot at the first sample of its present stance phase, (n, n_feet, 3)."""
    lands = down.copy()
    lands[1:] &= ~down[:-1]
    numbers = np.where(lands, np.arange(len(down))[:, None], 0)
    first = np.maximum.accumulate(numbers, axis=0)
    return np.take_along_axis(foot, first[..., None], axis=0)


def _foot_rows(
    trace: Trace, pattern: GaitPattern, stances: IntegerVector, feet: _Feet, bounds: ContactBounds
) -> list[Residual]:
    """One row per stance, foot and quantity that has a meaning there."""
    rows = []
    for number, stance in enumerate(pattern.visited):
        inside = stances == number
        if not np.any(inside):
            continue
        for column, foot in enumerate(pattern.robot.foot_names):
            where = f"{stance.name} {foot}"
            if foot not in stance.feet:
                height = feet.height[:, column]
                rows.append(
                    _worst(f"{where} height", "height", height, (-bounds.penetration, np.inf), trace, True, inside)
                )
                continue
            normal, friction, drift = (values[:, column] for values in (feet.normal, feet.friction, feet.drift))
            rows.append(
                _worst(
                    f"{where} normal force", "normal force", normal, (bounds.normal_force, np.inf), trace, True, inside
                )
            )
            rows.append(_worst(f"{where} friction", "friction", friction, (0.0, bounds.friction), trace, False, inside))
            rows.append(_worst(f"{where} drift", "drift", drift, (0.0, bounds.drift), trace, False, inside))
    return rows


def _joint_rows(trace: Trace, pattern: GaitPattern, bounds: ContactBounds) -> list[Residual]:
    """Largest |torque|, |speed| and share of its motor's line of every joint that has such a limit."""
    robot = pattern.robot
    torques, speeds = signal(trace, "torque"), trace.state[:, robot.size + robot.base.size :]
    torque, speed = np.abs(torques), np.abs(speeds)
    rows = []
    for column, joint in enumerate(robot.joint_names):
        for what, values, limits in (("torque", torque, bounds.torques), ("speed", speed, bounds.speeds)):
            if joint in limits:
                rows.append(_worst(f"{joint} {what}", what, values[:, column], (0.0, limits[joint]), trace, False))
        if joint in bounds.motors:
            motor = bounds.motors[joint]
            used = np.abs(torques[:, column] / motor.stall_torque + speeds[:, column] / motor.no_load_speed)
            rows.append(_worst(f"{joint} torque over speed", "motor", used, (0.0, 1.0), trace, False))
    return rows


def _worst(
    name: str,
    kind: str,
    values: Vector,
    bounds: tuple[float, float],
    trace: Trace,
    lowest: bool,
    inside: Mask | None = None,
) -> Residual:
    """Find the lowest or highest value, among the samples inside, and when it occurred."""
    candidates = np.arange(len(values)) if inside is None else np.flatnonzero(inside)
    chosen = values[candidates]
    index = int(candidates[np.argmin(chosen) if lowest else np.argmax(chosen)])
    time, cycle = float(trace.time[index]), int(trace.cycle[index])
    return Residual(name, bounds[0], float(values[index]), bounds[1], kind=kind, time=time, cycle=cycle)


def _sound_from(sound: Mask, cycles: IntegerVector) -> int | None:
    """Return the cycle after the last unsound one; None where the last cycle is unsound."""
    unsound = np.flatnonzero(~sound)
    if unsound.size == 0:
        return int(cycles[0])
    return None if unsound[-1] == len(sound) - 1 else int(cycles[unsound[-1] + 1])


@dataclass(frozen=True)
class Landings:
    """The distances of landing feet from the ground at the impacts of a motion.

    Attributes:
        rows: of every switch and foot the largest distance, above (positive) or below the ground, m.
        largest: the largest size of every cycle, (cycles,), m; 0 where no foot lands.
    """

    rows: tuple[Residual, ...]
    largest: Vector


def landings(trace: Trace, pattern: GaitPattern, stances: IntegerVector, gaps: NodeValues, bound: float) -> Landings:
    """Measure the landing feet at the last sample before every impact.

    Args:
        trace: the motion.
        pattern: its gait pattern.
        stances: index into ``pattern.visited`` of every sample, (n,).
        gaps: distances of all feet from the ground, (n, n_feet), m.
        bound: what is accepted in both directions, m.
    """
    ends = np.flatnonzero((np.diff(trace.domain) != 0) | (np.diff(trace.clock) < 0.0))
    entered = stances[ends + 1]
    if trace.completed:  # the last arc ends where the first domain is entered again
        ends, entered = np.append(ends, len(stances) - 1), np.append(entered, 0)
    first = int(trace.cycle[0])
    largest = np.zeros(int(trace.cycle[-1]) - first + 1)
    rows = []
    for switch in pattern.steps:
        source, target = pattern.visited.index(switch.source), pattern.visited.index(switch.target)
        there = ends[(stances[ends] == source) & (entered == target)]
        for foot in switch.landing if there.size else ():
            heights = gaps[there, pattern.robot.foot_names.index(foot)]
            np.maximum.at(largest, trace.cycle[there] - first, np.abs(heights))
            worst = int(np.argmax(np.abs(heights)))
            at = int(there[worst])
            name, time, cycle = f"{switch.name} height at touchdown {foot}", float(trace.time[at]), int(trace.cycle[at])
            rows.append(Residual(name, -bound, float(heights[worst]), bound, kind="height", time=time, cycle=cycle))
    return Landings(tuple(rows), frozen(largest))


def monitors(gait: Gait, trace: Trace) -> ContactReport:
    """Hold a simulated motion against the limits of its gait."""
    return contact_report(trace, gait.pattern, ContactBounds.of_gait(gait))
