"""Landing rules: what happens where several feet land at one switch (docs/theory/hybrid-model.md, section 10)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import combinations

from amble.errors import InputError, UnknownNameError
from amble.names import check_name

SIMULTANEOUS, ONE_BY_ONE = "simultaneous", "one by one"

LANDING_RULES = (ONE_BY_ONE, SIMULTANEOUS)
"""One by one: every foot is stopped when it reaches the ground; the first to land releases the feet that lift.
Simultaneous, an idealisation for planning: the touchdown of the first landing foot of a switch, in the robot's order of
feet, stops all of them. Where a single foot lands the rules are the same."""

MOST_LANDING = 6
"""Feet that may land at one switch one by one: k feet have k! orders and k 2^(k-1) landings, 192 of six."""


@dataclass(frozen=True)
class Stance:
    """One domain of a gait: its name and the feet on the ground, in the robot's foot order."""

    name: str
    feet: tuple[str, ...]

    def __post_init__(self) -> None:
        """Check the name."""
        check_name("stance", self.name)


@dataclass(frozen=True)
class Switch:
    """What happens between two stances: feet that land (plastic impact) and feet that lift.

    With a landing foot the guard is the gap of the first landing foot above the ground. Without one it is the mean
    normal force of the lifting feet less the smallest that a stance foot may have, so that they leave by one common
    event, and the reset is the identity (paper, section 2.4).
    """

    source: Stance
    target: Stance
    landing: tuple[str, ...]
    lifting: tuple[str, ...]

    @property
    def name(self) -> str:
        """Source and target."""
        return f"{self.source.name}->{self.target.name}"

    @property
    def leaving(self) -> tuple[str, ...]:
        """Feet that leave the ground by their force: those that lift where none lands."""
        return () if self.landing else self.lifting


def steps(switch: Switch, rule: str, feet: Sequence[str]) -> tuple[Switch, ...]:
    """Return the switches that a rule makes of one: itself, or every landing of one foot in every order.

    Between the landings stand the feet that do not lift and those that have landed; the stance is called by the next
    one and the landed feet, such as "D2 fr".

    Args:
        switch: from one stance of the gait to the next.
        rule: one of ``LANDING_RULES``.
        feet: all feet, in the robot's order.

    Raises:
        InputError: more than ``MOST_LANDING`` feet land one by one.
    """
    if rule == SIMULTANEOUS or len(switch.landing) < 2:
        return (switch,)
    if len(switch.landing) > MOST_LANDING:
        raise InputError(
            f"at switch '{switch.name}' {len(switch.landing)} feet land; by the landing rule '{ONE_BY_ONE}' at most "
            f"{MOST_LANDING} do: take '{SIMULTANEOUS}'"
        )
    kept = [foot for foot in switch.source.feet if foot not in switch.lifting]
    found = []
    for count in range(len(switch.landing)):
        for landed in combinations(switch.landing, count):
            before = _between(switch, landed, kept, feet)
            for foot in switch.landing:
                if foot not in landed:
                    after = _between(switch, (*landed, foot), kept, feet)
                    found.append(Switch(before, after, (foot,), switch.lifting if not landed else ()))
    return tuple(found)


def landed_stances(switch: Switch, rule: str, feet: Sequence[str]) -> tuple[Stance, ...]:
    """Return the stances behind every landing of every order, the next stance last; none where feet land at once."""
    chain = steps(switch, rule, feet)
    return tuple(dict.fromkeys(step.target for step in chain)) if len(chain) > 1 else ()


def check_rule(rule: str) -> None:
    """Raise UnknownNameError for a rule that does not exist."""
    if rule not in LANDING_RULES:
        raise UnknownNameError("landing rule", rule, LANDING_RULES)


def _between(switch: Switch, landed: Sequence[str], kept: Sequence[str], feet: Sequence[str]) -> Stance:
    if not landed:
        return switch.source
    if len(landed) == len(switch.landing):
        return switch.target
    down = tuple(foot for foot in feet if foot in landed or foot in kept)
    return Stance(" ".join([switch.target.name, *(foot for foot in feet if foot in landed)]), down)
