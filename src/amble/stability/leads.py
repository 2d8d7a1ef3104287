"""Torques in proportion to the change of the command in a step, so that a walk does not lag behind its orbits.

Shorthand of this file: x(c) the orbit of a command on the section, x' its slope along an axis, P(x; c, d) the state
after a step in which the command goes from c to c + d. A walk on x(c) ends the step at P(x(c); c, d), which misses
x(c + d) by E d to first order,

    E = dP/dd - x',    x' = (1 - A)^-1 dP(x(c); c + e, 0)/de.                                                      (1)

The steps contract slowly, so under changes that go on such misses add up to |E d| / (1 - r). Constant torques y d of
every joint and stance move the end of the step by S y d: those with the least |E + S y| in the metric in which all
steps contract, at a small price on |y|, leave little of it (docs/howto/transitions.md, eq. 4). The derivatives here
are differences: their errors are a miss of second order.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from amble.defaults import TOLERANCE
from amble.errors import WorkError
from amble.gait.closed_loop import closed_loop
from amble.gait.impedance import unpacked
from amble.gait.landing_stances import laws
from amble.gait.ramp import RampedImpedance, ramped
from amble.gait.schedule import Schedule
from amble.hybrid import HybridSystem
from amble.simulation.trace import COMPLETED
from amble.simulation.walk import walk
from amble.stability.sampled_step import SampledStep, on_section, section_coordinates
from amble.types import Matrix, NodeValues, Vector, frozen

STEP = 0.01
"""Change of a command in a difference, as a share of its range."""

TORQUE = 3e-4
"""Change of a torque in a difference, in m g l."""

PRICE = 1e-3
"""Price on torques, relative to the largest slope of the end of the step along them."""

TIME_LIMIT = 2.0
"""The longest stay in a domain, in gait periods."""


def with_leads(schedule: Schedule, samples: Mapping[tuple[float, ...], SampledStep], metric: Matrix) -> Schedule:
    """Return a schedule with the torques of changes of its command.

    Args:
        schedule: the law.
        samples: the step at every gait, by its command.
        metric: W of ``Tracking``.

    Raises:
        WorkError: a step that is a little off an orbit does not come to its end.
    """
    root = np.asarray(np.linalg.cholesky(metric).T, dtype=np.float64)
    ends = _Ends(schedule)
    found = [_lead(ends, samples[command], root) for command in itertools.product(*schedule.values)]
    shape = tuple(map(len, schedule.values))
    return replace(schedule, leads=frozen(np.reshape(found, (*shape, *found[0].shape))))


class _Ends:
    """Ends of steps on the section, on ground that feet do not leave."""

    def __init__(self, schedule: Schedule) -> None:
        somewhere = [row[0] for row in schedule.values]
        self.schedule, self.size = schedule, len(schedule.gait.robot.joints)
        self.places = {name: place for name, (place, _) in laws(schedule.gait).items()}
        self.system = closed_loop(schedule.gait, control=ramped(schedule, somewhere, somewhere), half=True)
        self.along, self.kept = section_coordinates(schedule, self.system)

    def __call__(
        self, state: Vector, before: Sequence[float], after: Sequence[float], torques: NodeValues | None = None
    ) -> Vector:
        """Return the end of a step, with torques added in every solved stance, (stances, n_joints)."""
        law = ramped(self.schedule, before, after)
        entries = [*law.entries, *law.between.values()]
        packed = [entry.parameters for entry in entries]
        if torques is not None:
            packed[: len(torques)] = _pushed(law, torques, self.size)
        domains = [
            replace(domain, parameters=packed[place], breakpoints=entries[place].breakpoints)
            for domain, place in ((domain, self.places[domain.name]) for domain in self.system.domains)
        ]
        system = HybridSystem(domains, self.system.transitions, (), self.system.state_names)
        arc = walk(system, state, 1, TOLERANCE, 2, TIME_LIMIT * self.schedule.gait.period)
        if arc.ended != COMPLETED:
            raise WorkError(f"a step beside an orbit {arc.ended}")
        return on_section(self.system, self.along, arc.events[-1].after).image[self.kept]


def _pushed(law: RampedImpedance, torques: NodeValues, joints: int) -> list[Vector]:
    """Add torques to the feed-forward at both ends of a ramp."""
    found = []
    for entry, more in zip(law.entries, torques, strict=True):
        shares, first, second = np.split(entry.parameters.copy(), [2, 2 + (entry.parameters.size - 2) // 2])
        for part in (first, second):
            unpacked(part, joints)[4][1, :, :, 0] += more  # the constant of every piece; a view
        found.append(frozen(np.concatenate([shares, first, second])))
    return found


def _lead(ends: _Ends, sample: SampledStep, root: Matrix) -> NodeValues:
    """The torques at one gait, (axes, stances, n_joints)."""
    schedule, here = ends.schedule, sample.command
    robot, stances = schedule.gait.robot, len(schedule.gait.pattern.solved)
    push = TORQUE * robot.mass * robot.gravity * robot.leg_length
    slopes = []
    for number in range(stances * ends.size):
        torques = np.zeros((stances, ends.size))
        torques.flat[number] = push
        up, down = (ends(sample.state, here, here, sign * torques) for sign in (1.0, -1.0))
        slopes.append(root @ (up - down) / (2.0 * push))
    slope = np.stack(slopes, axis=1)
    price = PRICE * np.linalg.norm(slope, 2) * np.eye(slope.shape[1])
    misses = [root @ _miss(ends, sample, axis) for axis in range(len(here))]
    wanted = np.concatenate([-np.stack(misses, axis=1), np.zeros((len(price), len(misses)))])
    found, *_ = np.linalg.lstsq(np.concatenate([slope, price]), wanted, rcond=None)
    return np.asarray(found.T.reshape(len(here), stances, ends.size))


def _miss(ends: _Ends, sample: SampledStep, axis: int) -> Vector:
    """E of (1) along an axis, by changes to both sides where there are gaits."""
    here, row = sample.command, ends.schedule.values[axis]
    side = STEP * (row[-1] - row[0])
    low, high = (
        (*here[:axis], min(max(here[axis] + sign * side, row[0]), row[-1]), *here[axis + 1 :]) for sign in (-1.0, 1.0)
    )
    span = high[axis] - low[axis]
    orbit = (ends(sample.state, high, high) - ends(sample.state, low, low)) / span
    ramp = (ends(sample.state, here, high) - ends(sample.state, here, low)) / span
    mean = np.mean(sample.matrices, axis=0)
    return np.asarray(ramp - np.linalg.solve(np.eye(len(mean)) - mean, orbit))
