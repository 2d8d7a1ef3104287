"""A library under drawn commands: a long walk on ground that pushes only, the exported C beside it at every event."""

from __future__ import annotations

import ctypes
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

import casadi as ca
import numpy as np

from amble.codegen import compiler
from amble.export import export_schedule
from amble.gait.impedance import references
from amble.gait.landing_stances import laws
from amble.gait.ramp import at_clock, ramped
from amble.gait.schedule import Schedule
from amble.simulation.steering import Stepper
from amble.simulation.trace import COMPLETED
from amble.simulation.walk import DomainArc
from amble.types import Matrix, Vector
from amble.workflow.library import Transitions, load_transitions

EVERY = 2.0
"""Time between two commands, s."""

SEED = 14

TICKS = 8
"""Of the C controller from one sample of a domain to the next: its ticks are a quarter of a stance at most."""

FLAGS = "-std=c99", "-O2", "-ffp-contract=off", "-shared", "-fPIC", "-DAMBLE_CONFIRM_TICKS=1"


def main(arguments: Sequence[str]) -> None:
    """Walk (arguments: folder of a library with transitions, number of commands, 1000 by default).

    Raises:
        SystemExit: the walk ends early, C and Python differ, or arguments are missing.
    """
    if len(arguments) not in (1, 2):
        raise SystemExit("python -m benchmarks.steering LIBRARY [COMMANDS]")
    found = load_transitions(arguments[0])
    count = int(arguments[1]) if len(arguments) == 2 else 1000
    asked = drawn(found.schedule, count)
    print(f"{count} commands of {', '.join(found.axes)}, changes of {found.changes} a step", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        ended, told = walked(found, asked, Path(folder))
    print(told)
    if ended != COMPLETED:
        raise SystemExit(ended)


def drawn(schedule: Schedule, count: int) -> Matrix:
    """Draw commands over the whole range, every second at least half a range from the last along an axis."""
    low, high = (np.array([row[end] for row in schedule.values]) for end in (0, -1))
    generator, found = np.random.default_rng(SEED), list[Vector]()
    while len(found) < count:
        command = generator.uniform(low, high)
        if len(found) % 2 == 0 or np.max(np.abs(command - found[-1]) / (high - low)) >= 0.5:
            found.append(command)
    return np.array(found)


def walked(found: Transitions, asked: Matrix, folder: Path) -> tuple[str, str]:
    """Walk under commands, and feed the C controller what the feet do; return how it ended, and what it came to."""
    step, beside = Stepper(found.schedule, found.friction), Beside(found, folder)
    at, clock, steps, irregular, arrived = asked[0], 0.0, 0, 0, set[int]()
    entry = step.start(found.schedule.start(at))
    beside.enter(at)
    while clock < EVERY * len(asked):
        number = int(clock / EVERY)
        wanted, before = asked[number], at
        at = at + np.clip(wanted - at, -np.array(found.changes), found.changes) if steps else at
        arc = step(steps % step.count, before.tolist(), at.tolist(), entry, 1e-8)
        last = arc.arcs[-1]
        clock += float(last.entered + last.arc.clock[-1])
        if arc.ended != COMPLETED:
            return arc.ended, f"after {steps} steps, {clock:.1f} s: {last.arc.ended or arc.ended}"
        next_asked = asked[min(int(clock / EVERY), len(asked) - 1)]
        beside.follow(arc.arcs, [event.after for event in arc.events], (before, at), next_asked)
        irregular += sum(event.transition.endswith(("released", "touched")) for event in arc.events)
        arrived |= {number} if np.allclose(at, wanted) else set()
        entry, steps = arc.events[-1].after, steps + 1
        if steps % 500 == 0:
            print(f"{steps} steps, {clock:.0f} s, C differs by {beside.worst / beside.peak:.3g}", flush=True)
    return COMPLETED, (
        f"{steps} steps, {clock:.1f} s; {len(arrived)} of {len(asked)} commands reached before the next; {irregular} "
        f"feet released or touched out of turn; C and Python differ by {beside.worst / beside.peak:.3g} of the peak "
        f"torque in {beside.calls} calls"
    )


class Beside:
    """The exported controller, ticked where the simulation's domains begin and end, against Python's torques."""

    def __init__(self, found: Transitions, folder: Path) -> None:
        """Export and compile it."""
        self.schedule, gait = found.schedule, found.schedule.gait
        exported = export_schedule(found.schedule, found.changes, folder / "controller")
        tool = compiler()
        if tool is None:
            raise SystemExit("no C compiler")
        library = folder / "controller.so"
        tool.build(exported.sources[0], library, (*FLAGS, f"-I{exported.folder}", "-lm"))
        self.library, self.joints, self.feet = ctypes.CDLL(str(library)), len(gait.robot.joints), gait.robot.foot_names
        self.memory, self.answer = ctypes.create_string_buffer(1 << 16), (ctypes.c_double * (6 * self.joints))()
        self.places, self.written = laws(gait), dict[int, ca.Function]()
        self.worst, self.peak, self.calls = 0.0, 0.0, 0

    def enter(self, command: Vector) -> None:
        """Begin a cycle."""
        self.library.amble_enter_at(self.memory, 0, (ctypes.c_double * len(command))(*command))

    def follow(
        self, arcs: Sequence[DomainArc], entries: Sequence[Vector], commands: tuple[Vector, Vector], following: Vector
    ) -> None:
        """Tick through the domains of a step; ``following`` is asked for before the event at which the next begins."""
        law = ramped(self.schedule, commands[0].tolist(), commands[1].tolist())
        packed = [entry.parameters for entry in (*law.entries, *law.between.values())]
        for number, (arc, after) in enumerate(zip(arcs, entries, strict=True)):
            if number + 1 == len(arcs):
                self.library.amble_steer(self.memory, (ctypes.c_double * len(following))(*following))
            state, before = arc.arc.state, 0.0
            for clock, here in zip(arc.arc.clock, state, strict=True):
                for _ in range(TICKS):
                    self._tick(float(clock - before) / TICKS, here)
                before = float(clock)
                self._compare(packed, here)
            self._tick(0.0, after)

    def _tick(self, dt: float, state: Vector) -> None:
        q, v, feet = self._parts(state)
        numbers = ctypes.c_double * self.joints
        flags = (ctypes.c_ubyte * len(feet))(*[int(foot > 0.5) for foot in feet])
        self.library.amble_step(self.memory, ctypes.c_double(dt), numbers(*q), numbers(*v), flags, self.answer)

    def _parts(self, state: Vector) -> tuple[Vector, Vector, Vector]:
        size = self.schedule.gait.robot.size
        contacts = state[2 * size + 1 : 2 * size + 1 + len(self.feet)]
        return state[size - self.joints : size], state[2 * size - self.joints : 2 * size], contacts

    def _compare(self, packed: Sequence[Vector], state: Vector) -> None:
        """Hold the sum of the motor command against Python's torque in the stance that C is in, at its clock."""
        stance = self.schedule.gait.pattern.visited[ctypes.cast(self.memory, ctypes.POINTER(ctypes.c_int))[0]]
        place, mirrored = self.places[stance.name]
        clock = float(state[2 * self.schedule.gait.robot.size])
        numbers = at_clock(packed[place], clock)
        if numbers.size not in self.written:
            t, p = ca.SX.sym("t"), ca.SX.sym("p", numbers.size)
            self.written[numbers.size] = ca.Function("references", [t, p], list(references(p, self.joints, t)))
        angle, rate, torque = (np.asarray(part).ravel() for part in self.written[numbers.size](clock, numbers))
        P, D = numbers[2 : 2 + self.joints], numbers[2 + self.joints : 2 + 2 * self.joints]
        if mirrored:
            mirror = self.schedule.gait.robot.mirror.joints
            angle, rate, torque, P, D = mirror(angle), mirror(rate), mirror(torque), P[mirror.index], D[mirror.index]
        q, v, _ = self._parts(state)
        expected = torque - P * (q - angle) - D * (v - rate)
        ours = np.array(self.answer[5 * self.joints :])
        self.worst = max(self.worst, float(np.abs(ours - expected).max()))
        self.peak, self.calls = max(self.peak, float(np.abs(expected).max())), self.calls + 1


if __name__ == "__main__":
    main(sys.argv[1:])
