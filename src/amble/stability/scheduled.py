"""How a gain-scheduled law follows commands: its orbits, one metric in which all steps contract, how fast it may move.

Shorthand of this file: c a command, x(c) the fixed point of the step map on the section (place and heading taken out),
A(c) the derivative there. With A(c)^T W A(c) < r^2 W and r < 1 for one W and all c that are sampled, small deviations
decay whatever the commands do. Torques in proportion to the change of the command keep a walk from lagging behind
(``leads``); how large the change D a step may be is tried: from every sampled orbit all sequences of steps up and down
by D are walked on ground that pushes only (docs/howto/transitions.md).
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from amble.amounts import check_amount
from amble.defaults import TOLERANCE
from amble.errors import WorkError
from amble.gait.schedule import Schedule
from amble.progress import Progress, ProgressReport, silent
from amble.simulation.steering import Stepper
from amble.simulation.trace import COMPLETED
from amble.stability.common_bound import common_bound
from amble.stability.leads import with_leads
from amble.stability.sampled_step import SampledStep, sampled_step
from amble.types import Matrix, Vector

DEPTH = 5
"""Steps of a sequence of commands; what is older has decayed."""

SHARES = tuple(2.0 ** (-0.5 * k) for k in range(27))
"""Changes of the command a step that are tried, descending, as shares of the range."""

MARGIN = 2.0**-0.5
"""Share of a change that was walked which commands may use: that of one change less of those tried."""

MOST_BETWEEN = 100


@dataclass(frozen=True, kw_only=True)
class Tracking:
    """How a schedule follows commands.

    Attributes:
        schedule: the law, with torques of changes of its command.
        samples: the steps at the gaits and between them.
        rate: r of the derivatives of all of them in one metric.
        metric: W, (m, m), in the states of the section.
        tried: change of every axis a step at which all sequences of commands were walked.
        changes: how far the command of every axis may move from step to step: ``MARGIN`` of that.
    """

    schedule: Schedule
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
    notify(ProgressReport(what="torques of changes of the command"))
    led = with_leads(schedule, {sample.command: sample for sample in samples}, bound.metric)
    spans = np.array([row[-1] - row[0] for row in schedule.values])
    stepper, reason = Stepper(led, friction), ""
    for share in SHARES:
        notify(ProgressReport(what=f"commands that change by {share:.2g} of the range a step"))
        reason = next(filter(None, (_failure(stepper, sample, share * spans) for sample in samples)), "")
        if not reason:
            break
    if reason:
        raise WorkError(f"commands that change by {SHARES[-1]:.2g} of the range a step cannot be followed: {reason}")
    return Tracking(
        schedule=led,
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

    def walked(depth: int, command: list[float], entry: Vector, corner: Vector) -> str:
        for sign in (1.0, -1.0):
            there = np.clip(np.array(command) + sign * corner * change, low, high).tolist()
            arc = stepper(depth % stepper.count, command, there, entry, TOLERANCE)
            if arc.ended != COMPLETED:
                return f"from {', '.join(f'{value:g}' for value in sample.command)} {arc.ended}"
            further = walked(depth + 1, there, arc.events[-1].after, corner) if depth + 1 < DEPTH else ""
            if further:
                return further
        return ""

    entry = stepper.start(sample.state)
    return next(filter(None, (walked(0, list(sample.command), entry, c) for c in _corners(len(change)))), "")


def _corners(axes: int) -> list[Vector]:
    """Corners of the box of changes, of two opposite ones the one that goes up along the first axis."""
    return [np.array([1.0, *rest]) for rest in itertools.product((1.0, -1.0), repeat=axes - 1)]
