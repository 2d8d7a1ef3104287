"""The stances of a gait between the landings of feet that land one by one."""

from __future__ import annotations

from collections.abc import Sequence

from amble.gait.record import Gait
from amble.hybrid import Stance, Switch
from amble.hybrid.landing import steps


def entering(gait: Gait, number: int) -> Switch:
    """Return the switch that enters the solved stance of a number."""
    return gait.pattern.all_switches[number - 1]


def landing_steps(gait: Gait, switch: Switch) -> tuple[Switch, ...]:
    """Return what the gait's rule makes of a switch; see ``hybrid.landing.steps``."""
    return steps(switch, gait.pattern.landing_rule, gait.robot.foot_names)


def between(gait: Gait, switch: Switch) -> tuple[Stance, ...]:
    """Return the stances between the landings of a switch."""
    sources = (step.source for step in landing_steps(gait, switch))
    return tuple(dict.fromkeys(stance for stance in sources if stance != switch.source))


def twin(gait: Gait, switch: Switch, stance: Stance) -> Stance:
    """Return the stance during the landings of a switch on the mirrored feet of another."""
    feet = {gait.robot.mirror.feet[foot] for foot in stance.feet}
    return next(step.target for step in landing_steps(gait, switch) if set(step.target.feet) == feet)


def follows(step: Switch, switch: Switch, order: Sequence[str]) -> bool:
    """Whether a landing of a switch is part of an order of its feet."""
    landed = set() if step.source == switch.source else set(step.source.feet) & set(switch.landing)
    return landed == set(order[: len(landed)]) and step.landing[0] == order[len(landed)]


def landings(gait: Gait) -> list[tuple[Stance, Stance]]:
    """Return the stances between the landings into every solved stance, each with that stance."""
    solved = gait.pattern.solved
    return [(stance, solved[n]) for n in range(len(solved)) for stance in between(gait, entering(gait, n))]


def laws(gait: Gait) -> dict[str, tuple[int, bool]]:
    """Return of every visited stance by name the place of its law and whether it is the mirrored one.

    The laws are those of the solved stances, then those between ``landings``.
    """
    pattern, solved = gait.pattern, len(gait.pattern.solved)
    found = {stance.name: (number % solved, number >= solved) for number, stance in enumerate(pattern.stances)}
    for place, (stance, following) in enumerate(landings(gait), start=solved):
        found[stance.name] = place, False
        if pattern.mirrored:
            image = pattern.all_switches[pattern.solved.index(following) - 1 + solved]
            found[twin(gait, image, stance).name] = place, True
    return found
