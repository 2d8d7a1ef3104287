"""The same gait or problem on other ground."""

from __future__ import annotations

from dataclasses import replace
from typing import TypeVar

from amble.gait import Gait
from amble.hybrid import Ground
from amble.synthesis import GaitProblem

Walk = TypeVar("Walk", Gait, GaitProblem)


def on_ground(walk: Walk, ground: Ground) -> Walk:
    """The same walk on another ground."""
    return replace(walk, pattern=replace(walk.pattern, ground=ground))


def on_friction(walk: Walk, friction: float) -> Walk:
    """The same walk on ground of the same shape with another friction."""
    return on_ground(walk, replace(walk.pattern.ground, friction=friction))
