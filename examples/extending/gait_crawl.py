"""A gait of one's own, from duty factors: one foot in the air at a time. One function, one registration."""

from __future__ import annotations

from collections.abc import Mapping

from amble.hybrid import FLAT, POINT, Contact, GaitPattern, Ground, gait_pattern
from amble.hybrid.gaits import GAITS
from amble.robot import Robot

CRAWL = {"rl": (0.0, 0.75), "fl": (0.25, 0.75), "rr": (0.5, 0.75), "fr": (0.75, 0.75)}
"""Foot -> (phase of the cycle at which it lands, share of the cycle that it stays on the ground)."""

ROUNDING = 1e-9


def stance_table(feet: Mapping[str, tuple[float, float]]) -> list[tuple[str, ...]]:
    """Return the feet on the ground between one landing or lift-off and the next, from phase 0 on.

    Args:
        feet: foot -> (landing phase, duty factor), both as shares of the cycle.
    """
    events = sorted({round(phase % 1.0, 9) for land, duty in feet.values() for phase in (land, land + duty)})
    ends = [*events[1:], events[0] + 1.0]
    middles = [0.5 * (begin + end) for begin, end in zip(events, ends, strict=True)]
    return [
        tuple(foot for foot, (land, duty) in feet.items() if (middle - land) % 1.0 < duty - ROUNDING)
        for middle in middles
    ]


def crawl(robot: Robot, ground: Ground = FLAT, contact: Contact = POINT) -> GaitPattern:
    """Each foot in turn swings for a quarter of the cycle: left rear, left front, right rear, right front."""
    return gait_pattern(robot, stance_table(CRAWL), mirrored=True, name="crawl", ground=ground, contact=contact)


GAITS.register("crawl", crawl)
