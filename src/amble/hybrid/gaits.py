"""Common gaits of a quadruped with feet called fl, fr, rl, rr, as tables of stance feet."""

from __future__ import annotations

from collections.abc import Callable

from amble.hybrid.contact import POINT, Contact
from amble.hybrid.ground import FLAT, Ground
from amble.hybrid.pattern import GaitPattern, gait_pattern
from amble.io.registry import Lookup
from amble.robot import Robot


def amble(robot: Robot, ground: Ground = FLAT, contact: Contact = POINT) -> GaitPattern:
    """Two feet down at every instant; each switch is one foot landing while another lifts (the paper's gait)."""
    table = [("fr", "rl"), ("fr", "rr"), ("fl", "rr"), ("fl", "rl")]
    return gait_pattern(robot, table, mirrored=True, name="amble", ground=ground, contact=contact)


def trot(robot: Robot, ground: Ground = FLAT, contact: Contact = POINT) -> GaitPattern:
    """Diagonal pairs in turn, without flight."""
    table = [("fl", "rr"), ("fr", "rl")]
    return gait_pattern(robot, table, mirrored=True, name="trot", ground=ground, contact=contact)


GAITS: Lookup[Callable[[Robot, Ground, Contact], GaitPattern]] = Lookup("gait")
"""The gaits that a specification can name: from a robot, its ground and its contact to the pattern."""

GAITS.register("amble", amble)
GAITS.register("trot", trot)
