"""A moving set through one domain: validated steps up to the guard, then the crossing and the reset."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb

from amble.progress import Progress, ProgressReport, silent
from amble.proof.arithmetic import ROOM, largest, radius
from amble.proof.crossing import cross
from amble.proof.errors import ProofError
from amble.proof.glide import NEWTON_STEPS, crossing, wished_length
from amble.proof.leg import Leg
from amble.proof.margins import MarginError, Watch
from amble.proof.moving_set import MovingSet
from amble.proof.step import MOST_STEPS, Step, StepError
from amble.proof.tape import NOT_ENCLOSED

ATTEMPTS = 14
HALVINGS = 6
"""How often a step is halved because a margin may fail along it."""
MOST_EXCESS = 1e3
"""A step whose remainder is larger than the tolerance by more is taken again, shorter."""


@dataclass(frozen=True)
class Arc:
    """What was proved of a domain.

    Attributes:
        after: the set at the entry of the next domain.
        lengths: of the steps, exact, s.
        duration: ball that holds the time of every crossing, s.
        margins: name -> proved lower bound along every motion, exact; a margin that starts at zero from where it has
            risen.
        points: clock and state, exact: of the set's centre at the start of every step, and where it meets the guard.
    """

    after: MovingSet
    lengths: list[arb]
    duration: arb
    margins: dict[str, arb]
    points: list[tuple[arb, list[arb]]]


def follow(
    leg: Leg,
    start: MovingSet,
    order: int,
    tolerance: float,
    lengths: Sequence[arb] | None = None,
    most: int = MOST_STEPS,
    progress: Progress = silent,
) -> Arc:
    """Move a set through a domain.

    Args:
        leg: the domain.
        start: the set at its entry.
        order: Q of the steps.
        tolerance: size of a step's remainder that the step length aims at.
        lengths: of the steps, where they are known; otherwise they are searched, and margins are proved with room for
            what another precision makes of them.
        most: steps.
        progress: called after every step.

    Raises:
        ProofError: what could not be proved, where, and how wide the set is there.
    """
    clock, here, taken = arb(0), start, list[arb]()
    points = [(clock, here.centre)]
    watch = leg.margins.watch(ROOM if lengths is None else arb(0))
    wish = arb(0)
    while len(taken) < most:
        try:
            if lengths is None:
                done, last, wish = _searched(leg, clock, here, watch, wish, order, tolerance)
            else:
                done = leg.field.step(clock, here.centre, here.hull(), lengths[len(taken)], order)
                last = not _quiet(leg, clock, done)
                watch.require(done.parts, leg.parameters)
            here = here.moved(done.image, done.slope)
            clock, taken = clock + done.length, [*taken, done.length]
            points.append((clock, here.centre))
            progress(_report(leg, here, len(taken)))
            if last:
                if not _rises(leg, done):
                    raise ProofError(f"the {leg.exit.name} may be crossed more than once")
                end = cross(leg, clock, here, watch)
                margins = {**watch.bounds, **end.margins}
                return Arc(after=end.after, lengths=taken, duration=end.duration, margins=margins, points=points)
        except (StepError, ProofError, IndexError, *NOT_ENCLOSED) as error:
            reason = "the steps end before the guard" if isinstance(error, IndexError) else str(error)
            raise ProofError(f"{reason} {leg.place(clock)}, where the set is {_width(here):.3g} wide") from None
    raise ProofError(f"{most} steps were not enough {leg.place(clock)}")


def _searched(
    leg: Leg, clock: arb, here: MovingSet, watch: Watch, wish: arb, order: int, tolerance: float
) -> tuple[Step, bool, arb]:
    """Take a step along which all margins hold, a shorter one where one may fail.

    Returns:
        The step, whether it ends at the crossing of the centre, and the length for the next one.
    """
    for attempt in range(HALVINGS + 1):
        done, wish = _fitting_step(leg, clock, here, wish, order, tolerance)
        last = not _quiet(leg, clock, done)
        if last:
            done, last = _to_the_guard(leg, clock, here, done, order)
        try:
            watch.require(done.parts, leg.parameters)
        except MarginError:
            if attempt == HALVINGS:
                raise
            wish = (done.length / 2).mid()
        else:
            break
    return done, last, wish


def _report(leg: Leg, here: MovingSet, number: int) -> ProgressReport:
    width = 2.0 * float(largest(map(radius, here.derivative().entries())))
    return ProgressReport(
        what=f"domain '{leg.domain.name}', step",
        done=number,
        quantity="width of the set",
        value=_width(here),
        detail=f"of the derivative {width:.3g}",
    )


def _width(here: MovingSet) -> float:
    return 2.0 * float(largest(map(radius, here.hull())))


def _fitting_step(leg: Leg, clock: arb, here: MovingSet, wish: arb, order: int, tolerance: float) -> tuple[Step, arb]:
    """Take a step whose remainder is about the tolerance; returns the length for the next one too.

    Args:
        leg: the domain.
        clock: of the start, s.
        here: the set.
        wish: length that the last step's remainder asks for; zero at the entry of a domain, s.
        order: Q.
        tolerance: of the remainder.

    Raises:
        StepError: not even a short step has an enclosure.
    """
    if not wish > 0:
        wish = wished_length(leg.field, clock, here.centre, order, tolerance)
    for attempt in range(ATTEMPTS):
        length = leg.cut(clock, wish)
        try:
            done = leg.field.step(clock, here.centre, here.hull(), length, order)
        except StepError:
            if attempt == ATTEMPTS - 1:
                raise
            wish = length / 2
            continue
        error = float(done.error)
        change = (tolerance / max(error, tolerance * 1e-12)) ** (1.0 / order)
        wish = (done.length * arb(min(0.9 * change, 2.0))).mid()
        if error <= MOST_EXCESS * tolerance:
            return done, wish
    raise StepError("the remainder of no step is as small as the tolerance")


def _quiet(leg: Leg, clock: arb, done: Step) -> bool:
    """Whether the guard cannot fire in a step from a clock: not looked at, away from zero, or crossed the other way."""
    if clock + done.length <= arb(leg.exit.dead_time):
        return True
    for part in done.parts:
        value, rate = leg.rises(part)
        if not (value < 0 or value > 0 or rate < 0):
            return False
    return True


def _rises(leg: Leg, done: Step) -> bool:
    """Whether the guard is crossed at most once in a step: in every part it is away from zero or rises, at last rises.

    It starts below zero, so that between parts that stay away from zero it can only come from below.
    """
    values = [leg.rises(part) for part in done.parts]
    rising = [bool(rate > 0) for _, rate in values]
    first = rising.index(True) if True in rising else len(rising)
    return all(rising[first:]) and bool(rising[-1]) and all(value < 0 for value, _ in values[:first])


def _to_the_guard(leg: Leg, clock: arb, here: MovingSet, done: Step, order: int) -> tuple[Step, bool]:
    """Shorten a step in which the guard may fire; returns it and whether it ends at the crossing of the centre.

    It ends there where the guard rises all along it; otherwise it is halved until the guard is quiet.
    """
    for _ in range(NEWTON_STEPS):
        end = crossing(leg, clock, done.centre, done.length)
        if end is not None and arb(0) < end <= done.length and clock + end > arb(leg.exit.dead_time):
            done = leg.field.step(clock, here.centre, here.hull(), end, order)
            if _rises(leg, done):
                return done, True
        half = (done.length / 2).mid()
        done = leg.field.step(clock, here.centre, here.hull(), half, order)
        if _quiet(leg, clock, done):
            return done, False
    raise ProofError(f"the {leg.exit.name} is not crossed transversally")
