"""A gait of one's own, from duty factors: a canter with a moment of flight. One function, one registration."""

from __future__ import annotations

from amble.hybrid import FLAT, POINT, Contact, Footfall, GaitPattern, Ground, gait_pattern, stance_table
from amble.hybrid.gaits import GAITS
from amble.robot import Robot

CANTER = {"rr": Footfall(0.0, 0.4), "rl": Footfall(0.25, 0.4), "fr": Footfall(0.25, 0.4), "fl": Footfall(0.5, 0.4)}
"""Foot -> phase of the cycle at which it lands, and share of the cycle that it stays on the ground."""


def canter(robot: Robot, ground: Ground = FLAT, contact: Contact = POINT) -> GaitPattern:
    """Right rear, then a diagonal pair, then left front; its second half does not mirror the first."""
    return gait_pattern(robot, stance_table(CANTER), name="canter", ground=ground, contact=contact)


GAITS.register("canter", canter)
