"""How a gain-scheduled law follows commands: its orbits, one metric in which all steps contract, how fast it may move.

Shorthand of this file: c a command, x(c) the fixed point of the step map on the section (place and heading taken out),
A(c) the derivative there. With A(c)^T W A(c) < r^2 W and r < 1 for one W and all c that are sampled, small deviations
decay whatever the commands do, and a command that moves by D a step keeps the walk within D |x'| r / (1 - r) of its
orbit in the norm of W (docs/howto/transitions.md, eq. 3). How large D may be is tried: from every sampled orbit all
sequences of steps up and down by D are walked on ground that pushes only.
"""

from __future__ import annotations

import contextlib
import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from amble.amounts import check_amount
from amble.defaults import TOLERANCE
from amble.errors import FallError, NotSolvedError, WorkError
from amble.gait.closed_loop import closed_loop
from amble.gait.schedule import Schedule
from amble.hybrid import HybridSystem
from amble.progress import Progress, ProgressReport, silent
from amble.simulation.steering import Stepper
from amble.simulation.trace import COMPLETED
from amble.stability.common_bound import common_bound
from amble.stability.fixed_point import FixedPoint, fixed_point
from amble.stability.group import Shift, act, generators
from amble.stability.landing_orders import orders_of
from amble.stability.monodromy import Monodromy, prepare_variational
from amble.stability.poincare import TIME_LIMIT
from amble.types import IntegerVector, Matrix, Vector, frozen

DEPTH = 5
"""Steps of a sequence of commands; what is older has decayed."""

SHARES = tuple(2.0**-k for k in range(2, 14))
"""Changes of the command a step that are tried, descending, as shares of the range."""

MARGIN = 0.5
"""Share of a change that was walked which commands may use."""

SEED = 0

MOST_BETWEEN = 100

STEPS = 50
SETTLED = 1e-12


@dataclass(frozen=True, kw_only=True)
class SampledStep:
    """The step map at one command.

    Attributes:
        command: one number an axis.
        state: its fixed point with place and heading zero, (2 n_q,).
        matrices: its derivatives there on the section, (m, m): one, or where feet land one by one one of every order.
        duration: of the step, s.
        speed: mean velocity along the way of the orbit, m/s.
        yaw_rate: mean rate of its heading, rad/s.
    """

    command: tuple[float, ...]
    state: Vector
    matrices: tuple[Matrix, ...]
    duration: float
    speed: float
    yaw_rate: float

    @property
    def radius(self) -> float:
        """Spectral radius of the step, the largest of its derivatives'."""
        return max(float(np.abs(np.linalg.eigvals(matrix)).max()) for matrix in self.matrices)


def section_coordinates(schedule: Schedule, system: HybridSystem) -> tuple[IntegerVector, IntegerVector]:
    """Return the places of the coordinates along the symmetries, and of all other states."""
    robot = schedule.gait.robot
    along = np.array([robot.coordinate_index(symmetry.name) for symmetry in system.symmetries], dtype=np.int64)
    return along, np.setdiff1d(np.arange(2 * robot.size), along)


def on_section(system: HybridSystem, along: IntegerVector, state: Vector) -> Shift:
    """Move a state along the symmetries to where their coordinates are zero.

    Raises:
        WorkError: the amounts do not converge.
    """
    shift = act(system, np.zeros(along.size), state)
    for _ in range(STEPS):
        miss = shift.image[along]
        if np.abs(miss).max(initial=0.0) <= SETTLED:
            return shift
        shift = act(system, shift.amounts - np.linalg.solve(shift.slopes[along], miss), state)
    raise WorkError("a state cannot be moved to the section along the symmetries")


def sampled_step(schedule: Schedule, command: Sequence[float]) -> SampledStep:
    """Find the orbit at a command and differentiate the step map on the section.

    Raises:
        NotSolvedError: there is none near the gaits around it.
    """
    gait, law = schedule.gait, schedule.law(command)
    system = closed_loop(gait, control=law, half=True)
    along, _ = section_coordinates(schedule, system)
    smooth = [closed_loop(gait, control=law, half=True, orders=order) for order in orders_of(gait)]
    try:
        found = _orbit(system, smooth, schedule.start(command))
        found = _orbit(system, smooth, on_section(system, along, found.state).image)
    except (NotSolvedError, FallError) as error:
        where = ", ".join(f"{axis} {value:g}" for axis, value in zip(schedule.axes, command, strict=True))
        raise NotSolvedError(
            f"between the gaits there is no orbit at {where} ({str(error).splitlines()[0]}): take gaits nearer to each "
            "other, or of more alike durations ([limits] duration)"
        ) from None
    maps = [prepare_variational(each)(found.state, TOLERANCE, TIME_LIMIT, 1, None) for each in smooth]
    way = np.hypot(found.shift.get("x", 0.0), found.shift.get("y", 0.0))
    return SampledStep(
        command=tuple(map(float, command)),
        state=found.state,
        matrices=tuple(_on_section(schedule, system, found.state, each) for each in maps or [found.monodromy]),
        duration=found.period,
        speed=float(way / found.period),
        yaw_rate=float(found.shift.get("yaw", 0.0) / found.period),
    )


def _orbit(system: HybridSystem, smooth: Sequence[HybridSystem], guess: Vector) -> FixedPoint:
    """Find the fixed point; where feet land one by one the map has a kink, and that of one order may lead to it."""
    try:
        return fixed_point(system, guess)
    except NotSolvedError:
        for each in smooth:
            with contextlib.suppress(NotSolvedError, FallError):
                return fixed_point(system, fixed_point(each, guess).state)
        raise


def _on_section(schedule: Schedule, system: HybridSystem, state: Vector, there: Monodromy) -> Matrix:
    """Return the derivative of a step map on the section, (m, m)."""
    along, kept = section_coordinates(schedule, system)
    shift, tangent = on_section(system, along, there.image), generators(system, state)
    project = np.eye(state.size) - tangent @ np.linalg.solve(tangent[along], np.eye(state.size)[along])
    return frozen((project @ shift.matrix @ there.matrix)[np.ix_(kept, kept)])


@dataclass(frozen=True, kw_only=True)
class Tracking:
    """How a schedule follows commands.

    Attributes:
        samples: the steps at the gaits and between them.
        rate: r of the derivatives of all of them in one metric.
        metric: W, (m, m), in the states of the section.
        tried: change of every axis a step at which all sequences of commands were walked.
        changes: how far the command of every axis may move from step to step: ``MARGIN`` of that.
    """

    samples: tuple[SampledStep, ...]
    rate: float
    metric: Matrix
    tried: tuple[float, ...]
    changes: tuple[float, ...]


def track(
    schedule: Schedule, between: int = 1, friction: float | None = None, progress: Progress | None = None
) -> Tracking:
    """Find out whether a schedule can be steered, and how fast commands may change.

    Args:
        schedule: the law.
        between: commands that are sampled between two gaits along every axis, 1 to 100.
        friction: of the ground, where it is not that of the gaits.
        progress: called with what is being computed.

    Raises:
        InputError: the number of samples is out of range.
        NotSolvedError: at a command between gaits there is no orbit.
        WorkError: the orbits do not contract in one metric, or the smallest change that is tried ends a walk.
    """
    check_amount("samples between two gaits", between, 1, MOST_BETWEEN)
    notify = progress or silent
    samples = list[SampledStep]()
    commands = list(itertools.product(*(_refined(row, between) for row in schedule.values)))
    for command in commands:
        notify(ProgressReport(what="commands", done=len(samples), of=len(commands)))
        samples.append(sampled_step(schedule, command))
    bound = common_bound([matrix for sample in samples for matrix in sample.matrices])
    if not (bound.verified and bound.rate < 1.0):
        raise WorkError(_no_metric(samples, bound.rate))
    spans = np.array([row[-1] - row[0] for row in schedule.values])
    stepper, reason = Stepper(schedule, friction), ""
    for share in SHARES:
        notify(ProgressReport(what=f"commands that change by {share:.2g} of the range a step"))
        reason = next(filter(None, (_failure(stepper, sample, share * spans) for sample in samples)), "")
        if not reason:
            break
    if reason:
        raise WorkError(f"commands that change by {SHARES[-1]:.2g} of the range a step cannot be followed: {reason}")
    return Tracking(
        samples=tuple(samples),
        rate=bound.rate,
        metric=bound.metric,
        tried=tuple(map(float, share * spans)),
        changes=tuple(map(float, MARGIN * share * spans)),
    )


def _no_metric(samples: Sequence[SampledStep], rate: float) -> str:
    worst = max(samples, key=lambda sample: sample.radius)
    return (
        f"the orbits do not contract in one metric (r = {rate:.4g}); the largest spectral radius of a step is "
        f"{worst.radius:.4g}, at {', '.join(f'{value:g}' for value in worst.command)}"
    )


def _refined(values: Sequence[float], between: int) -> list[float]:
    """The values, with more between every two."""
    parts = [np.linspace(a, b, between + 2)[:-1] for a, b in itertools.pairwise(values)]
    return [*map(float, np.concatenate(parts)), float(values[-1])]


def _failure(stepper: Stepper, sample: SampledStep, change: Vector) -> str:
    """Say how a walk ends under commands that go up or down by a change at every step; empty where none does."""
    low, high = (np.array([row[end] for row in stepper.schedule.values]) for end in (0, -1))
    generator = np.random.default_rng(SEED)

    def walked(depth: int, command: Vector, entry: Vector) -> str:
        for direction in _directions(len(change), generator):
            there = np.clip(command + direction * change, low, high)
            arc = stepper(depth % stepper.count, command, there, entry, TOLERANCE)
            if arc.ended != COMPLETED:
                return f"from {', '.join(f'{value:g}' for value in sample.command)} {arc.ended}"
            further = walked(depth + 1, there, arc.events[-1].after) if depth + 1 < DEPTH else ""
            if further:
                return further
        return ""

    return walked(0, np.array(sample.command), stepper.start(sample.state))


def _directions(axes: int, generator: np.random.Generator) -> Matrix:
    """Up and down along one axis; of several, a corner of the box that is drawn and the one opposite."""
    corner = generator.choice([-1.0, 1.0], axes) if axes > 1 else np.ones(1)
    return np.stack([corner, -corner])
