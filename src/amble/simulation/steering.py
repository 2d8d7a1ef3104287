"""Walking under commands that change: a gain-scheduled law on ground that pushes only, step by step.

A step is what the gaits of the schedule solve: half a cycle of mirrored gaits, a cycle of others. Where one begins it
is settled where the command goes in it, by so much at most, and on the way the law goes over
(docs/howto/transitions.md).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from math import ceil

import numpy as np

from amble.amounts import check_amount
from amble.defaults import TOLERANCE
from amble.errors import InputError
from amble.gait.landing_stances import between, laws
from amble.gait.plant_errors import PlantErrors
from amble.gait.ramp import ramped
from amble.gait.record import Gait
from amble.gait.schedule import Schedule
from amble.gait.unilateral_loop import RELEASED, TOUCHED, unilateral_loop
from amble.gait.unilateral_state import unilateral_start
from amble.hybrid import HybridSystem, Stance
from amble.progress import Progress, ProgressReport, silent
from amble.simulation.trace import COMPLETED
from amble.simulation.walk import HybridArc, walk
from amble.types import Matrix, Vector, frozen

TIME_LIMIT = 2.0
"""The longest stay in a domain, in gait periods."""

MOST_COMMANDS, LONGEST = 100_000, 1e5
"""Commands of a walk, and its duration, s."""


class Stepper:
    """The steps of a schedule on ground that pushes only."""

    def __init__(self, schedule: Schedule, friction: float | None = None) -> None:
        """Compile what all commands share.

        Args:
            schedule: the law.
            friction: of the ground, where it is not that of the gaits.
        """
        gait = schedule.gait
        self.schedule, self._limit = schedule, TIME_LIMIT * gait.period
        somewhere = [row[0] for row in schedule.values]
        law = ramped(schedule, somewhere, somewhere)
        whole = unilateral_loop(gait, control=law, errors=PlantErrors(friction=friction))
        self.state_names = tuple(whole.state_names[: 2 * gait.robot.size])
        self._laws = {name: place for name, (place, _) in laws(gait).items()}
        stances, solved = gait.pattern.stances, len(gait.pattern.solved)
        self._steps = [
            _step(whole, _inside(gait, stances[first : first + solved])) for first in range(0, len(stances), solved)
        ]

    @property
    def count(self) -> int:
        """Steps of a cycle: two of mirrored gaits, else one."""
        return len(self._steps)

    def start(self, state: Vector) -> Vector:
        """Return the unilateral state at the entry of a cycle with coordinates and rates ``state``, (2 n_q,)."""
        return unilateral_start(self.schedule.gait, state)

    def __call__(
        self, number: int, before: Sequence[float], command: Sequence[float], entry: Vector, tolerance: float
    ) -> HybridArc:
        """Walk one step.

        Args:
            number: which of a cycle's.
            before: the command where it begins, one number an axis.
            command: that where it ends.
            entry: unilateral state at its beginning.
            tolerance: of the integrator.

        Raises:
            InputError: a command lies outside the schedule.
        """
        law, system = ramped(self.schedule, before, command), self._steps[number]
        entries = [*law.entries, *law.between.values()]
        domains = []
        for domain in system.domains:
            name = _stance(domain.name)
            own = entries[self._laws[name]]
            ends = own.breakpoints if domain.name == name else ()  # only of one that goes as planned
            domains.append(replace(domain, parameters=own.parameters, breakpoints=ends))
        moved = HybridSystem(domains, system.transitions, (), system.state_names)
        return walk(moved, entry, 1, tolerance, 2, self._limit)


def _inside(gait: Gait, stances: Sequence[Stance]) -> list[str]:
    """Return the names of the stances of a step, with those between the landings that end each."""
    found = [stance.name for stance in stances]
    for switch in gait.pattern.all_switches:
        if switch.source in stances:
            found += [stance.name for stance in between(gait, switch)]
    return found


def _step(whole: HybridSystem, stances: Sequence[str]) -> HybridSystem:
    """Take the stances of a step out of the cycle, the last of them led back to the first."""
    inside = [domain for domain in whole.domains if _stance(domain.name) in stances]
    edges = [
        edge if _stance(edge.target) in stances else replace(edge, target=stances[0])
        for edge in whole.transitions
        if _stance(edge.source) in stances
    ]
    return HybridSystem(inside, edges, (), whole.state_names)


def _stance(domain: str) -> str:
    for what in (RELEASED, TOUCHED):
        domain = domain.removesuffix(f" {what}")
    return domain


@dataclass(frozen=True, kw_only=True)
class SteeredStep:
    """One step of a steered walk.

    Attributes:
        time: at its entry, s.
        asked: what was asked for then, one number an axis.
        command: where the law's command goes in it.
        state: coordinates and rates at its entry, (2 n_q,).
        irregular: feet released, or touched out of their turn, in it.
    """

    time: float
    asked: tuple[float, ...]
    command: tuple[float, ...]
    state: Vector
    irregular: int


@dataclass(frozen=True, kw_only=True)
class Steered:
    """A steered walk.

    Attributes:
        axes: what is commanded.
        state_names: of coordinates and rates, (2 n_q,).
        steps: in order.
        time: walked, s.
        state: coordinates and rates in the end, (2 n_q,).
        ended: "completed", or one sentence that says why and when it ended early.
    """

    axes: tuple[str, ...]
    state_names: tuple[str, ...]
    steps: tuple[SteeredStep, ...]
    time: float
    state: Vector
    ended: str

    @property
    def completed(self) -> bool:
        """Whether it walked to the end."""
        return self.ended == COMPLETED


def steer(
    step: Stepper,
    commands: Sequence[tuple[float, Sequence[float]]],
    changes: Sequence[float],
    duration: float,
    start: Vector | None = None,
    tolerance: float = TOLERANCE,
    progress: Progress | None = None,
) -> Steered:
    """Walk under commands.

    Args:
        step: of the schedule.
        commands: (time in s, one number an axis), in order of time, the first at 0, where the walk begins.
        changes: how far the command of every axis may move from step to step.
        duration: how long to walk at least, s.
        start: state at the entry of the first step, (2 n_q,); by default about the orbit of the first command.
        tolerance: of the integrator.
        progress: called after every step.

    Raises:
        InputError: commands are out of order or range, or too many; a change or the duration is not positive.
    """
    notify, schedule = progress or silent, step.schedule
    times, asked = checked_commands(schedule, commands, changes, duration)
    most, at = np.asarray(changes, dtype=np.float64), asked[0]
    entry = step.start(schedule.start(at) if start is None else start)
    size, clock, steps, ended = 2 * schedule.gait.robot.size, 0.0, list[SteeredStep](), COMPLETED
    while clock < duration and ended == COMPLETED:
        wanted = asked[np.searchsorted(times, clock, side="right") - 1]
        before = at
        at = at + np.clip(wanted - at, -most, most) if steps else at
        arc = step(len(steps) % step.count, before, at, entry, tolerance)
        irregular = sum(event.transition.endswith((RELEASED, TOUCHED)) for event in arc.events)
        steps.append(
            SteeredStep(
                time=clock,
                asked=tuple(map(float, wanted)),
                command=tuple(map(float, at)),
                state=frozen(entry[:size]),
                irregular=irregular,
            )
        )
        last = arc.arcs[-1]
        clock += float(last.entered + last.arc.clock[-1])
        completed = arc.ended == COMPLETED
        entry = arc.events[-1].after if completed else last.arc.state[-1]
        if not completed:
            ended = f"after {len(steps) - 1} steps, at {clock:.4g} s, {last.arc.ended or arc.ended}"
        notify(ProgressReport(what="walked (s)", done=int(clock), of=ceil(duration)))
    return Steered(
        axes=schedule.axes,
        state_names=step.state_names,
        steps=tuple(steps),
        time=clock,
        state=frozen(entry[:size]),
        ended=ended,
    )


def checked_commands(
    schedule: Schedule, commands: Sequence[tuple[float, Sequence[float]]], changes: Sequence[float], duration: float
) -> tuple[Vector, Matrix]:
    """Return the times of the commands, (n,), and the commands, (n, axes)."""
    check_amount("commands", len(commands), 1, MOST_COMMANDS)
    check_duration(duration)
    if len(changes) != len(schedule.axes) or not all(0.0 < change < np.inf for change in changes):
        raise InputError("every axis needs a largest change of its command a step, above 0")
    for _, row in commands:
        if len(row) != len(schedule.axes):
            raise InputError(f"a command has {len(row)} numbers; the axes are {', '.join(schedule.axes)}")
        schedule.weights(row)
    times = np.array([time for time, _ in commands], dtype=np.float64)
    if times[0] != 0.0 or not np.all(np.diff(times) > 0.0):
        raise InputError("the times of commands begin at 0 s and grow from one to the next")
    return times, np.array([row for _, row in commands], dtype=np.float64)


def check_duration(duration: float) -> None:
    """Refuse a walk without end.

    Raises:
        InputError: in one sentence.
    """
    if not 0.0 < duration <= LONGEST:
        raise InputError(f"the duration is {duration:g} s; it must be above 0 and at most {LONGEST:g}")
