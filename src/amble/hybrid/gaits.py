"""Common gaits of a quadruped with feet called fl, fr, rl, rr, as tables of stance feet."""

from __future__ import annotations

from amble.hybrid.pattern import GaitPattern, gait_pattern
from amble.robot import Robot


def amble(robot: Robot) -> GaitPattern:
    """Two feet down at every instant; each switch is one foot landing while another lifts (the paper's gait)."""
    table = [("fr", "rl"), ("fr", "rr"), ("fl", "rr"), ("fl", "rl")]
    return gait_pattern(robot, table, mirrored=True, name="amble")


def trot(robot: Robot) -> GaitPattern:
    """Diagonal pairs in turn, without flight."""
    return gait_pattern(robot, [("fl", "rr"), ("fr", "rl")], mirrored=True, name="trot")


GAITS = {"amble": amble, "trot": trot}
"""The gaits that a specification can name."""
