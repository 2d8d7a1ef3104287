"""A gait pattern: the cyclic table of stance feet, from which domains, guards and resets follow."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from amble.errors import InputError, UnknownNameError
from amble.hybrid.contact import POINT, Contact
from amble.hybrid.contacts import Contacts
from amble.hybrid.ground import FLAT, Ground
from amble.hybrid.landing import ONE_BY_ONE, Stance, Switch, check_rule, steps
from amble.names import check_distinct, check_name
from amble.robot import Robot


@dataclass(frozen=True, kw_only=True)
class GaitPattern:
    """A cyclic sequence of stances of one robot on a ground.

    Attributes:
        robot: the robot.
        stances: all stances of one gait cycle, in order.
        mirrored: whether the second half of the cycle is the left-right mirror of the first, so that half of the
            stances determine the gait.
        name: what the gait is called.
        ground: what the robot walks on.
        contact: what each of its feet on the ground is; of a robot in the plane its likeness there.
        landing_rule: what happens where several feet land at one switch, one of ``landing.LANDING_RULES``.
    """

    robot: Robot
    stances: tuple[Stance, ...]
    mirrored: bool
    name: str = "gait"
    ground: Ground = FLAT
    contact: Contact = POINT
    landing_rule: str = ONE_BY_ONE

    def __post_init__(self) -> None:
        """Check names, that every switch changes the stance and that the mirror holds where it is claimed."""
        object.__setattr__(self, "contact", self.contact.on(self.robot.base))
        if not (self.robot.base.in_space or self.ground.mirrored):
            raise InputError(
                f"robot '{self.robot.name}' moves in the plane of x and z: its ground cannot rise sideways"
            )
        check_name("gait", self.name)
        check_rule(self.landing_rule)
        check_distinct("stance", (stance.name for stance in self.visited))
        for switch in self.all_switches:
            if not switch.landing and not switch.lifting:
                raise InputError(f"stances '{switch.name}' have the same feet: {', '.join(switch.source.feet)}")
        if self.mirrored:
            self._check_mirror()

    @property
    def solved(self) -> tuple[Stance, ...]:
        """The stances that determine the gait: the first half where the gait is mirrored, else all."""
        return self.stances[: len(self.stances) // 2] if self.mirrored else self.stances

    @property
    def all_switches(self) -> tuple[Switch, ...]:
        """The switches of the whole cycle, the one that leaves each stance in order."""
        following = (*self.stances[1:], self.stances[0])
        return tuple(_switch(a, b) for a, b in zip(self.stances, following, strict=True))

    @property
    def switches(self) -> tuple[Switch, ...]:
        """The switches that leave the solved stances; where mirrored, the last one enters the mirrored first stance."""
        return self.all_switches[: len(self.solved)]

    @property
    def steps(self) -> tuple[Switch, ...]:
        """All switches of the closed loop: of several feet that land one by one, every landing in every order."""
        feet, rule = self.robot.foot_names, self.landing_rule
        return tuple(step for switch in self.all_switches for step in steps(switch, rule, feet))

    @property
    def visited(self) -> tuple[Stance, ...]:
        """All stances of the closed loop: the stances of the gait, then those between two landings."""
        return tuple(dict.fromkeys((*self.stances, *(step.source for step in self.steps))))

    def stance(self, name: str) -> Stance:
        """Look a stance up by name."""
        for candidate in self.stances:
            if candidate.name == name:
                return candidate
        raise UnknownNameError("stance", name, [s.name for s in self.stances])

    def contacts(self, stance: Stance) -> Contacts:
        """Return the feet of a stance on the ground."""
        return Contacts(self.robot, stance.feet, self.contact, self.ground)

    @property
    def all_contacts(self) -> Contacts:
        """All feet of the robot on the ground."""
        return Contacts(self.robot, self.robot.foot_names, self.contact, self.ground)

    def _check_mirror(self) -> None:
        if not self.ground.mirrored:
            raise InputError("a mirrored gait needs ground that is the same on the left and on the right")
        if len(self.stances) % 2:
            raise InputError(f"a mirrored gait has an even number of stances, not {len(self.stances)}")
        half = len(self.stances) // 2
        twin = self.robot.mirror.feet
        for first, second in zip(self.stances[:half], self.stances[half:], strict=True):
            if {twin[foot] for foot in first.feet} != set(second.feet):
                raise InputError(
                    f"stance '{second.name}' ({', '.join(second.feet)}) is not the mirror image of "
                    f"'{first.name}' ({', '.join(first.feet)})"
                )


def gait_pattern(
    robot: Robot,
    feet_down: Sequence[Sequence[str]],
    mirrored: bool = False,
    name: str = "gait",
    ground: Ground = FLAT,
    contact: Contact = POINT,
    landing_rule: str = ONE_BY_ONE,
) -> GaitPattern:
    """Build a pattern from a table of stance feet, one row a domain; domains are called D1, D2, ...

    Args:
        robot: the robot whose feet the table names.
        feet_down: for each domain the feet on the ground.
        mirrored: claim (checked) that the second half mirrors the first.
        name: what the gait is called.
        ground: what the robot walks on; by default level ground.
        contact: what each foot on the ground is; by default a point.
        landing_rule: what happens where several feet land at one switch.

    Raises:
        UnknownNameError: where the table names a foot the robot does not have.
        InputError: where two neighbouring rows agree, a row repeats a foot, or the claimed mirror does not hold.
    """
    stances = []
    for number, row in enumerate(feet_down, start=1):
        for foot in row:
            if foot not in robot.foot_names:
                raise UnknownNameError("foot", foot, robot.foot_names)
        if len(set(row)) != len(row):
            raise InputError(f"row {number} of the stance table repeats a foot: {', '.join(row)}")
        stances.append(Stance(f"D{number}", tuple(foot for foot in robot.foot_names if foot in row)))
    if len(stances) < 2:
        raise InputError("a gait pattern needs at least two stances")
    return GaitPattern(
        robot=robot,
        stances=tuple(stances),
        mirrored=mirrored,
        name=name,
        ground=ground,
        contact=contact,
        landing_rule=landing_rule,
    )


def _switch(source: Stance, target: Stance) -> Switch:
    landing = tuple(foot for foot in target.feet if foot not in source.feet)
    lifting = tuple(foot for foot in source.feet if foot not in target.feet)
    return Switch(source, target, landing, lifting)
