"""A moving set about a guard through the crossing and the reset.

Shorthand of this file: g the guard with its direction's sign, so that it rises through zero; f the field; R the reset;
d/dt g = g_x f + g_t. The crossing of a set that lies about the guard at clock t* happens within +-d,

    d >= max |g| / min d/dt g over a tube that holds the motion on t* +- d,

and the map from the set to the entry of the next domain has the slope of ``stability.monodromy`` (1), at the states
where the set crosses: a much smaller box than the tube, which holds all that happens within +-d.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from flint import arb, arb_mat

from amble.proof.arithmetic import column, identity, largest, symmetric
from amble.proof.errors import ProofError
from amble.proof.leg import Leg
from amble.proof.margins import Watch
from amble.proof.moving_set import MovingSet
from amble.proof.step import Part

TUBE_ATTEMPTS = 6


@dataclass(frozen=True, kw_only=True)
class Crossed:
    """What was proved of a crossing.

    Attributes:
        after: the set at the entry of the next domain.
        duration: ball that holds the clock of every crossing, s.
        margins: of the landing, name -> proved lower bound, exact.
    """

    after: MovingSet
    duration: arb
    margins: dict[str, arb]


def cross(leg: Leg, clock: arb, here: MovingSet, watch: Watch) -> Crossed:
    """Carry a set about the guard through the crossing and the reset.

    Args:
        leg: the domain.
        clock: at which the set is about the guard, s.
        here: the set.
        watch: of the domain's margins.

    Raises:
        ProofError: the guard is not crossed transversally, or in its dead time; or a margin may fail.
    """
    hull = here.hull()
    part, reach = _crossing_tube(leg, clock, hull)
    if not part.during > arb(leg.exit.dead_time):
        raise ProofError(f"the {leg.exit.name} is crossed while it is not looked at")
    watch.require([part], leg.parameters)
    landing = leg.landing.watch(watch.room)
    landing.require([part], leg.parameters)
    # the centre: it crosses at clock + delay
    _, speed = leg.rises(part)
    middle, _, _ = leg.exit.at(clock, here.centre, leg.parameters)
    delay = -middle / speed
    at = [centre + delay * change for centre, change in zip(here.centre, part.rate, strict=True)]
    image, _, _ = leg.reset.balls([clock + delay], at, leg.parameters)
    # every point: slope of the state at the crossing over the tube, so where the set crosses; the slope there
    size = leg.field.size
    steepest = arb_mat(size, size, [entry.abs_upper() for entry in leg.field.slope(part).entries()])
    grown = (steepest * reach.abs_upper()).exp() - identity(size)
    near_one = identity(size) + arb_mat(size, size, [symmetric(entry) for entry in grown.entries()])
    turned = _saltation(leg, part, identity(size), column([arb(0)] * size))
    crossed = _sharp(leg, part.during, here.moved(at, turned * near_one).hull())
    _, flat, reset_t = leg.reset.balls([part.during], crossed.box, leg.parameters)
    slope = _saltation(leg, crossed, arb_mat(size, len(image), flat).transpose(), column(reset_t))
    return Crossed(
        after=here.moved(image, slope * near_one),
        duration=clock - (leg.exit.at(clock, hull, leg.parameters)[0] / speed),
        margins=landing.bounds,
    )


def _saltation(leg: Leg, part: Part, slope: arb_mat, drift: arb_mat) -> arb_mat:
    """Return the slope of a function of the state at the crossing, which lies in a part.

    Args:
        leg: the domain.
        part: where the crossings are.
        slope: of the function along x.
        drift: along t, a column.
    """
    _, along, _ = leg.exit.at(part.during, part.box, leg.parameters)
    _, speed = leg.rises(part)
    moved = slope * column(part.rate) + drift
    return slope - moved * arb_mat(1, len(along), along) / speed


def _sharp(leg: Leg, during: arb, box: Sequence[arb]) -> Part:
    """Return a part with the rate by its slopes from the middle of box and clocks: a solution over them is wider."""
    part, middle, clock = leg.field.part(during, box), [value.mid() for value in box], during.mid()
    change = leg.field.slope(part) * column([value - at for value, at in zip(box, middle, strict=True)])
    drift = column(leg.field.drift(part)) * (during - clock)
    at_middle = column(leg.field.part(clock, middle).rate)
    return replace(part, rate=(at_middle + change + drift).entries())


def _crossing_tube(leg: Leg, clock: arb, hull: Sequence[arb]) -> tuple[Part, arb]:
    """Return what holds the motions on clock +- d, and d itself, such that every motion crosses within.

    A tube holds them where it holds hull + [-d, d] f(tube): Picard's iterates then stay in it, and it is closed. It
    need not be larger, so nothing is asked of coordinates that hardly move or are exact, whose tube is their hull.
    """
    start = leg.field.part(clock, hull)
    value, speed = leg.rises(start)
    if not speed > 0:
        raise ProofError(f"the {leg.exit.name} is not crossed transversally")
    rates, reach = start.rate, (2 * largest([value]) / speed).upper() + arb(2) ** -200
    for _ in range(TUBE_ATTEMPTS):
        part = leg.field.part(clock + symmetric(reach), _within(hull, 2 * reach, rates))
        held = zip(part.box, _within(hull, reach, part.rate), strict=True)
        _, speed = leg.rises(part)
        far = speed > 0 and largest([value]) < reach * speed.lower()
        if far and all(tube.contains(reached) for tube, reached in held):
            return part, reach
        rates, reach = part.rate, reach if far else 2 * reach
    raise ProofError(f"the crossing of the {leg.exit.name} could not be enclosed")


def _within(hull: Sequence[arb], reach: arb, rates: Sequence[arb]) -> list[arb]:
    """Return where states of a box can come to in a time of at most the reach, forward or backward."""
    return [at + symmetric(reach * change.abs_upper()) for at, change in zip(hull, rates, strict=True)]
