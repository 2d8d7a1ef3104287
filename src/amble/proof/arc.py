"""A moving set through one domain: validated steps up to the guard, the crossing, the reset.

Shorthand of this file: g the guard with its direction's sign, so that it rises through zero; f the field; R the reset;
d/dt g = g_x f + g_t. The crossing of a set that lies about the guard at clock t* happens within +-d,

    d >= max |g| / min d/dt g over a tube that holds the motion on t* +- d,

and the map from the set to the entry of the next domain has the slope of ``stability.monodromy`` (1) over that tube.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from flint import arb, arb_mat

from amble.progress import Progress, ProgressReport, silent
from amble.proof.arithmetic import ROOM, column, identity, inside, largest, radius, symmetric
from amble.proof.errors import ProofError
from amble.proof.glide import NEWTON_STEPS, crossing, wished_length
from amble.proof.leg import Leg, Surface
from amble.proof.margins import MarginError, Watch
from amble.proof.moving_set import MovingSet
from amble.proof.step import Part, Step, StepError
from amble.proof.tape import NOT_ENCLOSED

TUBE_ATTEMPTS = 6
ATTEMPTS = 14
HALVINGS = 6
"""How often a step is halved because a margin may fail along it."""
JUST_BEFORE = arb(2) ** -60
"""Share of a dead time at which a step ends before its end, so that it is known to lie within."""
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
    """

    after: MovingSet
    lengths: list[arb]
    duration: arb
    margins: dict[str, arb]


def follow(
    leg: Leg,
    start: MovingSet,
    order: int,
    tolerance: float,
    lengths: Sequence[arb] | None = None,
    most: int = 20000,
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
    watch = leg.margins.watch(ROOM if lengths is None else arb(0))
    wish = arb(0)
    while len(taken) < most:
        try:
            if lengths is None:
                done, last, wish = _searched(leg, clock, here, watch, wish, order, tolerance)
            else:
                done = leg.field.step(clock, here.centre, here.hull(), lengths[len(taken)], order)
                last = not _quiet(leg.exit, leg, clock, done)
                _check(leg, watch, clock, done)
            here = here.moved(done.image, done.slope)
            clock, taken = clock + done.length, [*taken, done.length]
            progress(_report(leg, here, len(taken)))
            if last:
                if not _rises(leg.exit, leg, done):
                    raise ProofError(f"the {leg.exit.name} may be crossed more than once")
                return _cross(leg, clock, here, taken, watch)
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
        last = not _quiet(leg.exit, leg, clock, done)
        if last:
            done, last = _to_the_guard(leg, clock, here, done, order)
        try:
            _check(leg, watch, clock, done)
        except MarginError:
            if attempt == HALVINGS:
                raise
            wish = (done.length / 2).mid()
        else:
            break
    return done, last, wish


def _check(leg: Leg, watch: Watch, clock: arb, done: Step) -> None:
    """Ask that no other guard fires in a step and that all margins hold."""
    for other in leg.others:
        if not _quiet(other, leg, clock, done):
            raise ProofError(f"the {other.name} may fire")
    watch.require(done.parts, leg.parameters)


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
        length = _cut(leg, clock, wish.mid())
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


def _cut(leg: Leg, clock: arb, length: arb) -> arb:
    """Return a step length that passes no breakpoint, and ends just before the end of a dead time that it would pass."""
    for mark in leg.domain.breakpoints:
        if clock < arb(mark) and clock + length > arb(mark):
            length = (arb(mark) - clock).mid()
    for guard in (leg.exit, *leg.others):
        before = arb(guard.dead_time) * (1 - JUST_BEFORE)
        if clock < before and clock + length > before:
            length = (before - clock).mid()
    return length


def _quiet(guard: Surface, leg: Leg, clock: arb, done: Step) -> bool:
    """Whether a guard cannot fire in a step from a clock: not looked at, away from zero, or crossed the other way."""
    if clock + done.length <= arb(guard.dead_time):
        return True
    for part in done.parts:
        value, rate = leg.rises(guard, part)
        if not (value < 0 or value > 0 or rate < 0):
            return False
    return True


def _rises(guard: Surface, leg: Leg, done: Step) -> bool:
    """Whether a guard is crossed at most once in a step: in every part it is away from zero or rises, at last rises.

    It starts below zero, so that between parts that stay away from zero it can only come from below.
    """
    values = [leg.rises(guard, part) for part in done.parts]
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
            if _rises(leg.exit, leg, done):
                return done, True
        half = (done.length / 2).mid()
        done = leg.field.step(clock, here.centre, here.hull(), half, order)
        if _quiet(leg.exit, leg, clock, done):
            return done, False
    raise ProofError(f"the {leg.exit.name} is not crossed transversally")


def _cross(leg: Leg, clock: arb, here: MovingSet, lengths: list[arb], watch: Watch) -> Arc:
    """Carry a set about the guard through the crossing and the reset."""
    hull = here.hull()
    part, reach = _crossing_tube(leg, clock, hull)
    if not part.during > arb(leg.exit.dead_time):
        raise ProofError(f"the {leg.exit.name} is crossed while it is not looked at")
    watch.require([part], leg.parameters)
    landing = leg.landing.watch(watch.room)
    landing.require([part], leg.parameters)
    # the centre: it crosses at clock + delay
    _, speed = leg.rises(leg.exit, part)
    middle, _, _ = leg.exit.at(clock, here.centre, leg.parameters)
    delay = -middle / speed
    at = [centre + delay * change for centre, change in zip(here.centre, part.rate, strict=True)]
    image, _, _ = leg.reset.balls([clock + delay], at, leg.parameters)
    # every point: slope of the state at the crossing over the tube, so where the set crosses; the slope there
    size = leg.field.size
    steepest = arb_mat(size, size, [entry.abs_upper() for entry in leg.field.slope(part).entries()])
    grown = (steepest * reach.abs_upper()).exp() - identity(size)
    near_one = identity(size) + arb_mat(size, size, [symmetric(entry) for entry in grown.entries()])
    turned, _ = _saltation(leg, part, identity(size), column([arb(0)] * size))
    crossed = _sharp(leg, part.during, here.moved(at, turned * near_one).hull())
    _, flat, reset_t = leg.reset.balls([part.during], crossed.box, leg.parameters)
    slope, speed = _saltation(leg, crossed, arb_mat(size, len(image), flat).transpose(), column(reset_t))
    return Arc(
        after=here.moved(image, slope * near_one),
        lengths=lengths,
        duration=clock - (leg.exit.at(clock, hull, leg.parameters)[0] / speed),
        margins={**watch.bounds, **landing.bounds},
    )


def _saltation(leg: Leg, part: Part, slope: arb_mat, drift: arb_mat) -> tuple[arb_mat, arb]:
    """Return the slope of a function of the state at the crossing, which lies in a part, and the guard's rate there.

    Args:
        leg: the domain.
        part: where the crossings are.
        slope: of the function along x.
        drift: along t, a column.
    """
    _, along, _ = leg.exit.at(part.during, part.box, leg.parameters)
    _, speed = leg.rises(leg.exit, part)
    moved = slope * column(part.rate) + drift
    return slope - moved * arb_mat(1, len(along), along) / speed, speed


def _sharp(leg: Leg, during: arb, box: Sequence[arb]) -> Part:
    """Return a part with the rate by its slope from the middle of the box: a solution over the box is wider."""
    part = leg.field.part(during, box)
    middle = [value.mid() for value in box]
    change = leg.field.slope(part) * column([value - at for value, at in zip(box, middle, strict=True)])
    rate = [a + b for a, b in zip(leg.field.part(during, middle).rate, change.entries(), strict=True)]
    return replace(part, rate=rate)


def _crossing_tube(leg: Leg, clock: arb, hull: Sequence[arb]) -> tuple[Part, arb]:
    """Return what holds the motions on clock +- d, and d itself, such that every motion crosses within."""
    start = leg.field.part(clock, hull)
    value, speed = leg.rises(leg.exit, start)
    if not speed > 0:
        raise ProofError(f"the {leg.exit.name} is not crossed transversally")
    reach = (2 * largest([value]) / speed).upper() + arb(2) ** -200
    for _ in range(TUBE_ATTEMPTS):
        tube = [
            at + symmetric(4 * reach * change.abs_upper() + reach * reach)
            for at, change in zip(hull, start.rate, strict=True)
        ]
        part = leg.field.part(clock + symmetric(reach), tube)
        held = [at + symmetric(reach * change.abs_upper()) for at, change in zip(hull, part.rate, strict=True)]
        _, speed = leg.rises(leg.exit, part)
        if inside(held, tube) and speed > 0 and largest([value]) < reach * speed.lower():
            return part, reach
        reach = 2 * reach
    raise ProofError(f"the crossing of the {leg.exit.name} could not be enclosed")
