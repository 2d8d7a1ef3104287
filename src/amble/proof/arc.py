"""A moving set through one domain: validated steps up to the guard, the crossing, the reset.

Shorthand of this file: g the guard with its direction's sign, so that it rises through zero; f the field; R the reset;
d/dt g = g_x f + g_t. The crossing of a set that lies about the guard at clock t* happens within +-d,

    d >= max |g| / min d/dt g over a tube that holds the motion on t* +- d,

and the map from the set to the entry of the next domain has the slope of ``stability.monodromy`` (1) over that tube.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from flint import arb, arb_mat

from amble.proof.arithmetic import column, horner, identity, inside, largest, row_sum_norm, symmetric
from amble.proof.leg import Leg, ProofError, Surface
from amble.proof.moving_set import MovingSet
from amble.proof.step import Step, StepError, take_step
from amble.proof.tape import NOT_ENCLOSED

NEWTON_STEPS = 20
TUBE_ATTEMPTS = 6
MOST_EXCESS = 1e3
"""A step whose remainder is larger than the tolerance by more is taken again, shorter."""


@dataclass(frozen=True)
class Arc:
    """What was proved of a domain.

    Attributes:
        after: the set at the entry of the next domain.
        lengths: of the steps, exact, s.
        duration: ball that holds the time of every crossing, s.
    """

    after: MovingSet
    lengths: list[arb]
    duration: arb


def follow(
    leg: Leg, start: MovingSet, order: int, tolerance: float, lengths: Sequence[arb] | None = None, most: int = 20000
) -> Arc:
    """Move a set through a domain.

    Args:
        leg: the domain.
        start: the set at its entry.
        order: Q of the steps.
        tolerance: size of a step's remainder that the step length aims at.
        lengths: of the steps, where they are known; otherwise they are searched.
        most: steps.

    Raises:
        ProofError: what could not be proved.
    """
    clock, here, taken = arb(0), start, list[arb]()
    wish = arb(0)
    planned = list(lengths) if lengths is not None else None
    while len(taken) < most:
        centre, box = here.centre, here.hull()
        try:
            if planned is not None:
                done = take_step(leg.field, clock, centre, box, planned[len(taken)], order, halve=False)
            else:
                done, wish = _fitting_step(leg, clock, here, wish, order, tolerance)
            last = not _quiet(leg.exit, leg, clock, done)
            if last and planned is None:
                done, last = _to_the_guard(leg, clock, here, done, order)
            for other in leg.others:
                if not _quiet(other, leg, clock, done):
                    raise ProofError(f"the {other.name} may fire {leg.place(clock)}")
            _require_margins(leg, clock, done)
        except (StepError, *NOT_ENCLOSED) as error:
            raise ProofError(f"{error} {leg.place(clock)}") from None
        here = here.moved(done.image, done.slope)
        clock, taken = clock + done.length, [*taken, done.length]
        if last:
            if not _rises(leg.exit, leg, clock - done.length, done):
                raise ProofError(f"the {leg.exit.name} may be crossed more than once {leg.place(clock)}")
            after, duration = _cross(leg, clock, here)
            return Arc(after, taken, duration)
    raise ProofError(f"{most} steps were not enough {leg.place(clock)}")


def _fitting_step(leg: Leg, clock: arb, here: MovingSet, wish: arb, order: int, tolerance: float) -> tuple[Step, arb]:
    """Take a step whose remainder is about the tolerance; returns the length for the next one too.

    Args:
        leg: the domain.
        clock: of the start, s.
        here: the set.
        wish: length that the last step's remainder asks for; zero at the entry of a domain, s.
        order: Q.
        tolerance: of the remainder.
    """
    if not wish > 0:
        size = float(largest(leg.field.motion(clock, here.centre, order)[order]))
        wish = arb(0.3 * (tolerance / max(size, tolerance**2)) ** (1.0 / order))
    while True:
        length = wish.mid()
        for mark in (*leg.domain.breakpoints, *(guard.dead_time for guard in (leg.exit, *leg.others))):
            if clock < arb(mark) and clock + length > arb(mark):
                length = (arb(mark) - clock).mid()
        done = take_step(leg.field, clock, here.centre, here.hull(), length, order)
        error = float(largest(done.polynomial[-1]) * done.length**order)
        change = (tolerance / max(error, tolerance * 1e-12)) ** (1.0 / order)
        wish = (done.length * arb(min(0.9 * change, 2.0))).mid()
        if error <= MOST_EXCESS * tolerance:
            return done, wish


def _quiet(guard: Surface, leg: Leg, clock: arb, done: Step) -> bool:
    """Whether a guard cannot fire in a step: not looked at, away from zero, or only crossed the other way."""
    if clock + done.length <= arb(guard.dead_time):
        return True
    during = clock.union(clock + done.length)
    value, along, drift = guard.at(during, done.tube, leg.parameters)
    return bool(value < 0) or bool(value > 0) or bool(leg.rate(during, done.tube, along, drift) < 0)


def _rises(guard: Surface, leg: Leg, clock: arb, done: Step) -> bool:
    during = clock.union(clock + done.length)
    _, along, drift = guard.at(during, done.tube, leg.parameters)
    return bool(leg.rate(during, done.tube, along, drift) > 0)


def _require_margins(leg: Leg, clock: arb, done: Step) -> None:
    during = clock.union(clock + done.length)
    for margin in leg.margins:
        value, _, _ = margin.at(during, done.tube, leg.parameters)
        if not value > 0:
            low = value.lower().str(4, radius=False)
            raise ProofError(f"the margin of {margin.name} is only known to be above {low} {leg.place(clock)}")


def _to_the_guard(leg: Leg, clock: arb, here: MovingSet, done: Step, order: int) -> tuple[Step, bool]:
    """Shorten a step in which the guard may fire; returns it and whether it ends at the crossing of the centre.

    It ends there where the guard rises all along it; otherwise it is halved until the guard is quiet.
    """
    for _ in range(NEWTON_STEPS):
        crossing = _root(leg, clock, done, done.length)
        if crossing is not None and arb(0) < crossing <= done.length:
            done = take_step(leg.field, clock, here.centre, here.hull(), crossing, order, halve=False)
            if _rises(leg.exit, leg, clock, done):
                return done, True
        half = (done.length / 2).mid()
        done = take_step(leg.field, clock, here.centre, here.hull(), half, order, halve=False)
        if _quiet(leg.exit, leg, clock, done):
            return done, False
    raise ProofError(f"the {leg.exit.name} is not crossed transversally {leg.place(clock)}")


def _root(leg: Leg, clock: arb, done: Step, start: arb) -> arb | None:
    """Newton for the time at which the centre's polynomial meets the guard; not rigorous, and need not be."""
    at = start
    for _ in range(NEWTON_STEPS):
        state = [horner([row[i].mid() for row in done.polynomial], at).mid() for i in range(leg.field.size)]
        value, along, drift = leg.exit.at(clock + at, state, leg.parameters)
        change = (value / leg.rate(clock + at, state, along, drift)).mid()
        at = (at - change).mid()
        if not at.is_finite():
            return None
        if abs(change) <= abs(at) * arb(2) ** -100:
            return at
    return None


def _cross(leg: Leg, clock: arb, here: MovingSet) -> tuple[MovingSet, arb]:
    """Carry a set about the guard through the crossing and the reset."""
    hull = here.hull()
    tube, reach = _crossing_tube(leg, clock, hull)
    during = clock + symmetric(reach)
    _, along, drift = leg.exit.at(during, tube, leg.parameters)
    (rate,) = leg.field.motion(during, tube, 1)[1:]
    speed = sum((slope * change for slope, change in zip(along, rate, strict=True)), start=drift)
    # the centre: it crosses at clock + delay
    middle, _, _ = leg.exit.at(clock, here.centre, leg.parameters)
    delay = -middle / speed
    crossing = [centre + delay * change for centre, change in zip(here.centre, rate, strict=True)]
    image, _, _ = leg.reset.balls([clock + delay], crossing, leg.parameters)
    # every point: slope of state at the crossing, then of the reset
    size = leg.field.size
    _, flat, reset_t = leg.reset.balls([during], tube, leg.parameters)
    reset_x = arb_mat(size, len(image), flat).transpose()
    moved = reset_x * column(rate) + column(reset_t)
    slope = reset_x - moved * arb_mat(1, size, along) / speed
    jacobian = leg.field.slopes(during, [tube])[0]
    gain = row_sum_norm(jacobian) * reach.abs_upper()
    extra = symmetric(gain / (1 - gain))
    near_one = arb_mat(size, size, [entry + extra for entry in identity(size).entries()])
    return here.moved(image, slope * near_one), clock - (leg.exit.at(clock, hull, leg.parameters)[0] / speed)


def _crossing_tube(leg: Leg, clock: arb, hull: Sequence[arb]) -> tuple[list[arb], arb]:
    """Return a box that holds the motions on clock +- d and d itself, such that every motion crosses within."""
    value, along, drift = leg.exit.at(clock, hull, leg.parameters)
    speed = leg.rate(clock, hull, along, drift)
    if not speed > 0:
        raise ProofError(f"the {leg.exit.name} is not crossed transversally {leg.place(clock)}")
    reach = (2 * largest([value]) / speed).upper() + arb(2) ** -200
    for _ in range(TUBE_ATTEMPTS):
        (rate,) = leg.field.motion(clock, hull, 1)[1:]
        tube = [
            at + symmetric(4 * reach * change.abs_upper() + reach * reach)
            for at, change in zip(hull, rate, strict=True)
        ]
        during = clock + symmetric(reach)
        (within,) = leg.field.motion(during, tube, 1)[1:]
        held = [at + symmetric(reach * change.abs_upper()) for at, change in zip(hull, within, strict=True)]
        _, along, drift = leg.exit.at(during, tube, leg.parameters)
        speed = leg.rate(during, tube, along, drift)
        if inside(held, tube) and speed > 0 and largest([value]) < reach * speed.lower():
            return tube, reach
        reach = 2 * reach
    raise ProofError(f"the crossing of the {leg.exit.name} could not be enclosed {leg.place(clock)}")
