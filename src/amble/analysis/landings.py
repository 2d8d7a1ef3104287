"""How far from the ground a landing foot is when an impact stops it: the model has only feet that land on it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from amble.hybrid import GaitPattern
from amble.residual import Residual
from amble.simulation import Trace
from amble.types import IntegerVector, NodeValues, Vector, frozen


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
