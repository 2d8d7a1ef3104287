"""The impedance law of a step in which the command moves: one law goes over into another, without a jump.

Let A and B be the packed numbers of the laws at the commands where a step begins and ends (``Schedule.law``). At the
share s of the step the law's numbers are (1 - s) A + s B. Within a stance s grows in proportion to its clock, up to the
planned duration there, and keeps its value from then on (docs/howto/transitions.md, eq. 3). So the references have no
jump where a step begins, and where a stance ends early only a small one. Torques in proportion to the change of the
command, ``Schedule.leads``, make up for what the robot would lag behind its orbits.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import casadi as ca
import numpy as np

from amble.gait.control_law import Numbers
from amble.gait.impedance import HOLD, PackedImpedance, unpacked
from amble.gait.landing_stances import landings
from amble.gait.record import Gait
from amble.gait.schedule import InterpolatedImpedance, Schedule
from amble.hybrid import Contacts, Stance
from amble.numerics.pieces import FAR
from amble.types import Vector, frozen

SHARES = 2
"""Numbers of a stance before those of both laws: the shares of the step at which it begins and ends."""


@dataclass(frozen=True, kw_only=True, eq=False)
class RampedImpedance(InterpolatedImpedance):
    """The law of a step that goes over from one command to another.

    Attributes:
        entries: of every solved stance: shares at its begin and end, numbers of the first law, of the second.
        between: the same of every stance between two landings, by its name; there the share stays.
    """

    @property
    def name(self) -> str:
        """Name in messages."""
        return "ramped impedance"

    def planned(self, gait: Gait, stance: Stance, p: ca.MX) -> ca.MX:
        """Read the plan: the duration at which the share is that of the stance's end."""
        del gait, stance
        return planned(p)

    @staticmethod
    def torques(contacts: Contacts, t: ca.SX, q: ca.SX, v: ca.SX, p: ca.SX) -> ca.SX:
        """Write the impedance law with the numbers at a clock."""
        return PackedImpedance.torques(contacts, t, q, v, at_clock(p, t, ca.fmin))


def ramped(schedule: Schedule, before: Sequence[float], after: Sequence[float]) -> RampedImpedance:
    """Return the law of a step in which the command moves.

    Args:
        schedule: the law at every command.
        before: the command where the step begins, one number an axis.
        after: that where it ends.

    Raises:
        InputError: a command lies outside the gaits.
    """
    change = np.subtract(after, before)
    first, second = (_led(schedule, command, change) for command in (before, after))
    shares, solved = shares_of(first), schedule.gait.pattern.solved
    joints = len(schedule.gait.robot.joints)
    entries = tuple(
        _numbers((shares[k], shares[k + 1]), a, b, joints)
        for k, (a, b) in enumerate(zip(first.entries, second.entries, strict=True))
    )
    between = {
        stance.name: _numbers((share, share), first.between[stance.name], second.between[stance.name], joints)
        for stance, share in (
            # the landings into the first stance end the step before
            (stance, shares[solved.index(following) or -1])
            for stance, following in landings(schedule.gait)
        )
    }
    return RampedImpedance(entries=entries, between=between, lift_offs=first.lift_offs)


def _led(schedule: Schedule, command: Sequence[float], change: Vector) -> InterpolatedImpedance:
    """The law at a command, with the torques of a change added to the feed-forward of its solved stances."""
    law = schedule.law(command)
    joints, torques = len(schedule.gait.robot.joints), np.tensordot(change, schedule.lead(command), axes=1)
    entries = []
    for entry, more in zip(law.entries, torques, strict=True):
        packed = entry.parameters.copy()
        unpacked(packed, joints)[4][1, :, :, 0] += more  # the constant of every piece; a view
        entries.append(replace(entry, parameters=frozen(packed)))
    return replace(law, entries=tuple(entries))


def shares_of(law: InterpolatedImpedance) -> Vector:
    """Return the shares of a step at which its stances begin, and 1, by their planned durations."""
    durations = np.array([entry.parameters[1] for entry in law.entries])
    ends = np.cumsum(durations) / durations.sum()
    return frozen([0.0, *ends[:-1], 1.0])


def planned(p: Any) -> Any:
    """Return the planned duration of a stance, s, from its numbers, a vector or casadi column."""
    first, second = _laws(p)
    return (first[1] + p[1] * (second[1] - first[1])) / HOLD


def at_clock(p: Any, clock: Any, minimum: Callable[[Any, float], Any] = min) -> Any:
    """Return the law's numbers at a clock of a stance.

    Args:
        p: numbers of the stance, a vector or casadi column.
        clock: s.
        minimum: of two numbers; of casadi's ``fmin``.
    """
    first, second = _laws(p)
    share = p[0] + (p[1] - p[0]) * minimum(clock / planned(p), 1.0)
    return first + share * (second - first)


def _laws(p: Any) -> tuple[Any, Any]:
    """Take both laws out of the numbers of a stance."""
    middle = SHARES + (p.shape[0] - SHARES) // 2
    return p[SHARES:middle], p[middle:]


def _numbers(shares: tuple[float, float], first: Numbers, second: Numbers, joints: int) -> Numbers:
    """Pack a stance, with the clocks at which its law is not smooth."""
    packed = np.concatenate([shares, first.parameters, second.parameters])
    duration = float(planned(packed))
    begin, growth = shares[0], (shares[1] - shares[0]) / duration
    found = {duration}
    for a, b in zip(_ends(first.parameters, joints), _ends(second.parameters, joints), strict=True):
        clock = (a + begin * (b - a)) / (1.0 - growth * (b - a))  # where it is the end at its own clock's share
        found.add(float(clock if clock < duration else a + shares[1] * (b - a)))
    return Numbers(parameters=frozen(packed), breakpoints=tuple(sorted(found)))


def _ends(packed: Vector, joints: int) -> list[float]:
    """Ends of pieces, of the last of them, and where all stands still, s."""
    ends, _, _, places, _ = unpacked(packed, joints)
    begins = places[0, 1:]
    return [*map(float, begins[begins < 0.5 * FAR]), *map(float, ends)]  # sums of weights round
