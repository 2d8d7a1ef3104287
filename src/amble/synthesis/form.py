"""What of a gait problem its program is written from: problems of one form differ in parameters and bounds alone.

The rows of a program take the velocities and the friction as parameters, and on level ground positions are bounded as
variables. So the program of a neighbour is written, differentiated and placed already; its bounds and parameters are
its own.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, fields, replace
from functools import lru_cache

from amble.hybrid import GaitPattern, Plane
from amble.robot import Robot
from amble.synthesis.problem import GaitProblem

WALKING, TURNING, FRICTION = 1.0, 1.0, 1.0
"""Speed, m/s, yaw rate, rad/s, and friction of the problem that stands for all of its form."""


@dataclass(frozen=True)
class Form:
    """All that a program is written from; forms are equal where that is, and can be kept as keys.

    Attributes:
        content: what is compared: all of the problem, or of its own copy where a mapping could change.
        problem: a problem of this form whose parameters say nothing of the one that it was made from.
    """

    content: tuple[object, ...]
    problem: GaitProblem = field(compare=False)

    @classmethod
    def of(cls, problem: GaitProblem) -> Form | None:
        """Return the form of a problem; None where a part of it might change, such as a law of one's own with state."""
        limits, posture = problem.limits, problem.posture
        level = problem.pattern.ground.level
        plain = replace(
            limits,
            durations=dict(limits.durations),
            positions={} if level else dict(limits.positions),
            speeds=dict(limits.speeds),
            torques=dict(limits.torques),
            motors=dict(limits.motors),
        )
        if not _settled(problem.pattern):
            return None
        same = replace(
            problem,
            pattern=_on_one_friction(problem.pattern),
            speed=WALKING,
            lateral_speed=0.0,
            yaw_rate=0.0 if problem.command.straight else TURNING,
            limits=plain,
            posture=replace(posture, angles=dict(posture.angles)),
        )
        content = _content(same)
        return cls(content, same) if _settled(content) else None


@lru_cache(maxsize=64)
def _on_one_friction(pattern: GaitPattern) -> GaitPattern:
    """The pattern on a plane of the friction that stands for all; other grounds may make of it what they like."""
    if type(pattern.ground) is not Plane:
        return pattern
    return replace(pattern, ground=replace(pattern.ground, friction=FRICTION))


def _content(part: object) -> tuple[object, ...]:
    """The fields of a record with those of records in it that hold mappings; mappings as their items in order."""
    found: list[object] = [type(part)]
    for each in fields(part):  # type: ignore[arg-type]
        value = getattr(part, each.name)
        if isinstance(value, Mapping):
            found.append(tuple(value.items()))
        elif each.name in ("limits", "posture"):
            found.append(_content(value))
        else:
            found.append(value)
    return tuple(found)


def _settled(value: object) -> bool:
    """Whether a value can never change, so that what once was equal to it stays so."""
    if value is None or isinstance(value, bool | int | float | str | type | Robot):
        return True
    if isinstance(value, tuple | frozenset):
        return all(_settled(each) for each in value)
    made = vars(type(value)).get("__dataclass_params__")  # its own: a subclass may have state that is not compared
    return made is not None and made.frozen and all(_settled(getattr(value, each.name)) for each in fields(value))  # type: ignore[arg-type]
