"""Gaits as data: named tables of stance feet for robots with two, four and six feet, open to others by ``GAITS``."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from amble.errors import InputError, listed
from amble.hybrid.contact import POINT, Contact
from amble.hybrid.footfalls import Footfall, stance_table
from amble.hybrid.ground import FLAT, Ground
from amble.hybrid.landing import ONE_BY_ONE, SIMULTANEOUS
from amble.hybrid.pattern import GaitPattern, gait_pattern
from amble.io.registry import Lookup
from amble.robot import Robot

Table = tuple[tuple[str, ...], ...]

QUADRUPED = ("fl", "fr", "rl", "rr")


@dataclass(frozen=True, kw_only=True)
class NamedGait:
    """A gait by name: called with a robot it is the pattern of stances that fits the robot's feet.

    Attributes:
        name: the name.
        tables: feet on the ground in every stance, in order; one table for every set of feet that has the gait.
        mirrored: whether the second half of the cycle is the left-right mirror of the first.
        landing_rule: what happens where several feet land at one switch.
    """

    name: str
    tables: tuple[Table, ...]
    mirrored: bool = True
    landing_rule: str = ONE_BY_ONE

    def __call__(self, robot: Robot, ground: Ground = FLAT, contact: Contact = POINT) -> GaitPattern:
        """Return the pattern of a robot.

        Raises:
            InputError: no table is for feet of these names, or the robot has no mirror.
        """
        for table in self.tables:
            if set(_feet(table)) == set(robot.foot_names):
                return gait_pattern(robot, table, self.mirrored, self.name, ground, contact, self.landing_rule)
        known = " or ".join(listed(sorted(_feet(table))) for table in self.tables)
        raise InputError(
            f"gait '{self.name}' is for feet called {known}; robot '{robot.name}' has {listed(robot.foot_names)}: name "
            "its feet so, or give the stances"
        )


def _feet(table: Table) -> dict[str, None]:
    return dict.fromkeys(foot for row in table for foot in row)


def _one_by_one(duty: float) -> Table:
    """Left rear, left front, right rear, right front: a quarter of the cycle apart."""
    return stance_table({foot: Footfall(0.25 * place, duty) for place, foot in enumerate(("rl", "fl", "rr", "fr"))})


DIAGONALS: Table = (("fl", "rr"), ("fr", "rl"))

amble = NamedGait(name="amble", tables=((("fr", "rl"), ("fr", "rr"), ("fl", "rr"), ("fl", "rl")),))
"""Two feet down at every instant; each switch is one foot landing while another lifts (the paper's gait)."""

trot = NamedGait(name="trot", tables=(DIAGONALS,))
"""Diagonal pairs in turn, without flight."""

SHIPPED = (
    amble,
    trot,
    NamedGait(name="walking trot", tables=((DIAGONALS[0], QUADRUPED, DIAGONALS[1], QUADRUPED),)),
    NamedGait(name="running trot", tables=((DIAGONALS[0], (), DIAGONALS[1], ()),)),
    NamedGait(name="pace", tables=((("fl", "rl"), ("fr", "rr")),)),
    NamedGait(name="bound", tables=((("fl", "fr"), ("rl", "rr")),), mirrored=False, landing_rule=SIMULTANEOUS),
    NamedGait(name="pronk", tables=((QUADRUPED, ()), (("l", "r"), ())), mirrored=False, landing_rule=SIMULTANEOUS),
    NamedGait(name="walk", tables=(_one_by_one(0.625), (("l",), ("r",)))),
    NamedGait(name="crawl", tables=(_one_by_one(0.875),)),
    NamedGait(name="run", tables=((("l",), (), ("r",), ()),)),
    NamedGait(name="tripod", tables=((("fl", "mr", "rl"), ("fr", "ml", "rr")),), landing_rule=SIMULTANEOUS),
)
"""What amble ships: trots without and with an overlap on four feet (2-4-2-4) and with flight, pace and bound without
flight, pronk on all feet at once, walk on three and two feet by turns (3-2-3-2; of a biped on one), crawl on four and
three (4-3-4-3), the run of a biped, the tripod of a hexapod.

Feet of a bound land at once: one that lands alone turns the robot about its centre of percussion and drives the foot
diagonal to it, just released, into the ground, unless it comes down much faster sideways than downwards. Three or four
feet that land one by one do so in 6 or 24 orders: no tripod was found, and a pronk takes minutes to stabilise."""

GAITS: Lookup[Callable[[Robot, Ground, Contact], GaitPattern]] = Lookup("gait")
"""The gaits that a specification can name: from a robot, its ground and its contact to the pattern."""

for known in SHIPPED:
    GAITS.register(known.name, known)
