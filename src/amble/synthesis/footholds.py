"""Paths of the feet in a walk that kinematics alone can draw: footholds under the hips, parabolas between them."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from amble.hybrid import GaitPattern
from amble.types import Matrix, Vector


def foot_path(
    pattern: GaitPattern,
    durations: Mapping[str, float],
    foot: str,
    home: Vector,
    walk: tuple[float, float],
    times: Vector,
) -> Matrix:
    """Return the positions of a foot while the base advances evenly, (times, 3), m.

    A stance foot rests where its home is in the middle of its stance, so a gait whose two halves mirror each other
    has paths that do; a swing foot crosses to its next foothold on a parabola.

    Args:
        pattern: which feet stand when, and on what ground.
        durations: solved domain -> duration, s.
        foot: the foot.
        home: where the foot stands at time 0 in the robot's posture, (3,), m.
        walk: speed of the base, m/s, and height of the parabola, m.
        times: s, from the entry of the first domain.
    """
    speed, height = walk
    path = np.tile(home, (times.size, 1))
    spans = stance_span(pattern, durations, foot)
    if spans is None:
        # A foot that never lands hangs in the air; one that never lifts can only drag along.
        path[:, 0] += speed * times
        lift = 0.0 if foot in pattern.stances[0].feet else height
        path[:, 2] = pattern.ground.height(path[:, 0], path[:, 1]) + lift
        return path
    landing, stance, cycle = spans
    laps, phase = np.divmod(times - landing + 1e-9 * cycle, cycle)
    progress = np.clip((phase - stance) / (cycle - stance), 0.0, 1.0)
    foothold = landing + 0.5 * stance + laps * cycle
    path[:, 0] += speed * (foothold + cycle * progress**2 * (3.0 - 2.0 * progress))
    path[:, 2] = pattern.ground.height(path[:, 0], path[:, 1]) + height * 4.0 * progress * (1.0 - progress)
    return path


def stance_span(pattern: GaitPattern, durations: Mapping[str, float], foot: str) -> tuple[float, float, float] | None:
    """Return when a foot lands, how long it stands, and the period, s; None where it never lands or never lifts."""
    stances, solved = pattern.stances, pattern.solved
    lengths = np.array([durations[solved[k % len(solved)].name] for k in range(len(stances))])
    down = [foot in stance.feet for stance in stances]
    if all(down) or not any(down):
        return None
    first = next(k for k in range(len(down)) if down[k] and not down[k - 1])
    stance, k = 0.0, first
    while down[k % len(down)]:
        stance += float(lengths[k % len(down)])
        k += 1
    return float(lengths[:first].sum()), stance, float(lengths.sum())
