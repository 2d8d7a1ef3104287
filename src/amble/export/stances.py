"""The stances of an exported controller: those of the gait, then those between the landings of one switch."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from amble.gait import Gait
from amble.gait.landing_stances import between, laws
from amble.hybrid import Stance


@dataclass(frozen=True, kw_only=True)
class ExportedStance:
    """A stance and where its law comes from.

    Attributes:
        stance: the stance.
        law: place of its law: those of the solved stances come first, then those between landings.
        mirrored: whether the law is evaluated in the mirror.
        before: feet that stand before it, which may still touch while it is young.
        after: feet that stand in the next stance of the gait.
    """

    stance: Stance
    law: int
    mirrored: bool
    before: tuple[str, ...]
    after: tuple[str, ...]

    @property
    def lifts(self) -> bool:
        """Whether the stance ends as feet leave and none lands: it does so where they are up, too."""
        return set(self.after) <= set(self.stance.feet)


def exported_stances(gait: Gait) -> list[ExportedStance]:
    """Return all stances in the order of their numbers in C, which is that of ``GaitPattern.visited``."""
    places, around = laws(gait), _around(gait)
    return [
        ExportedStance(
            stance=stance,
            law=places[stance.name][0],
            mirrored=places[stance.name][1],
            before=around[stance.name][0],
            after=around[stance.name][1],
        )
        for stance in gait.pattern.visited
    ]


def _around(gait: Gait) -> dict[str, tuple[tuple[str, ...], tuple[str, ...]]]:
    """Return of every stance by name the feet that stand before it, and in the gait's next stance."""
    stances = gait.pattern.stances
    found = {
        stance.name: (stances[number - 1].feet, stances[(number + 1) % len(stances)].feet)
        for number, stance in enumerate(stances)
    }
    for switch in gait.pattern.all_switches:
        found |= {stance.name: (switch.source.feet, switch.target.feet) for stance in between(gait, switch)}
    return found


def mask(gait: Gait, feet: Sequence[str]) -> int:
    """Return feet as bits, in the robot's order."""
    return sum(1 << gait.robot.foot_names.index(foot) for foot in feet)


def switch_tables(gait: Gait) -> list[str]:
    """Write what stands in every stance, and which flags lead from one to another."""
    stances = exported_stances(gait)
    numbers = {entry.stance.name: number for number, entry in enumerate(stances)}

    def row(kind: str, name: str, values: Sequence[object]) -> str:
        return f"static const {kind} {name}[AMBLE_STANCES] = {{{', '.join(map(str, values))}}};"

    edges = [
        f"  {{{numbers[step.source.name]}, {numbers[step.target.name]}, {mask(gait, step.landing)}u, "
        f"{mask(gait, step.lifting)}u}}"
        for step in gait.pattern.steps
    ]
    return [
        "/* Feet on the ground in every stance, one bit a foot; before it, and in the gait's next stance. */",
        row("unsigned", "DOWN", [f"{mask(gait, entry.stance.feet)}u" for entry in stances]),
        row("unsigned", "BEFORE", [f"{mask(gait, entry.before)}u" for entry in stances]),
        row("unsigned", "AFTER", [f"{mask(gait, entry.after)}u" for entry in stances]),
        "/* Place of the law of every stance, and whether it is evaluated in the mirror. */",
        row("int", "LAW_OF", [entry.law for entry in stances]),
        row("int", "MIRRORED", [int(entry.mirrored) for entry in stances]),
        "/* Switches: all feet of the first mask have landed; where it is empty, none of the second touches. */",
        f"#define SWITCHES {len(edges)}",
        "static const struct { int source, target; unsigned landing, lifting; } SWITCH[SWITCHES] = {",
        ",\n".join(edges) + "};",
    ]
