"""A moving set through one domain: validated steps up to the guard, the crossing, the reset.

Shorthand of this file: g the guard with its direction's sign, so that it rises through zero; f the field; R the reset;
d/dt g = g_x f + g_t. The crossing of a set that lies about the guard at clock t* happens within +-d,

    d >= max |g| / min d/dt g over a tube that holds the motion on t* +- d,

and the map from the set to the entry of the next domain has the slope of ``stability.monodromy`` (1) over that tube.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import casadi as ca
from flint import arb, arb_mat

from amble.errors import InputError, WorkError
from amble.hybrid import Domain, Transition
from amble.proof.arithmetic import column, identity, inside, largest, row_sum_norm, symmetric
from amble.proof.moving_set import MovingSet
from amble.proof.step import Step, StepError, take_step
from amble.proof.tape import NOT_ENCLOSED, Tape, record
from amble.proof.taylor import ExplicitField, Field

NEWTON_STEPS = 20
TUBE_ATTEMPTS = 6
MOST_EXCESS = 1e3
"""A step whose remainder is larger than the tolerance by more is taken again, shorter."""


class ProofError(WorkError):
    """A proof does not succeed: the step of it that fails, where along the orbit, and by how much."""


@dataclass(frozen=True)
class Surface:
    """A guard or a margin with its slopes, over (t, x, p).

    Attributes:
        name: of what it is.
        values: tape of the function, its slope along x and its slope along t.
        sign: by which it is multiplied.
        dead_time: clock before which it is not looked at, s.
    """

    name: str
    values: Tape
    sign: int
    dead_time: float = 0.0

    @classmethod
    def of(cls, name: str, function: ca.Function, sign: int, dead_time: float = 0.0) -> Surface:
        """Differentiate a function of (t, x, p)."""
        t, x, p = _symbols(function)
        value = ca.densify(function(t, x, p))
        slopes = [value, ca.densify(ca.jacobian(value, x)), ca.densify(ca.jacobian(value, t))]
        return cls(name, record(ca.Function("surface", [t, x, p], slopes)), sign, dead_time)

    def at(self, clock: arb, state: Sequence[arb], parameters: Sequence[arb]) -> tuple[arb, list[arb], arb]:
        """Return g, g_x, g_t."""
        (value,), along, (drift,) = self.values([clock], state, parameters)
        return self.sign * value, [self.sign * slope for slope in along], self.sign * drift


@dataclass(frozen=True)
class Leg:
    """A domain as the proof needs it.

    Attributes:
        domain: itself.
        transition: that ends it.
        field: its vector field.
        exit: guard of that transition.
        others: guards of its other transitions, which must not fire.
        margins: that must stay positive.
        reset: tape of R, R_x by columns, R_t.
        parameters: the value of p.
    """

    domain: Domain
    transition: Transition
    field: Field
    exit: Surface
    others: tuple[Surface, ...]
    margins: tuple[Surface, ...]
    reset: Tape
    parameters: tuple[arb, ...]

    @classmethod
    def of(cls, domain: Domain, transition: Transition, leaving: Sequence[Transition]) -> Leg:
        """Prepare a domain.

        Raises:
            InputError: a function is compiled code, holds an operation without an enclosure, or the transition fires at
                the entry.
        """
        if any(item.at_entry for item in leaving):
            raise InputError(f"domain '{domain.name}' may be left at its entry (simultaneous guards): no proof of that")
        t, x, p = _symbols(transition.reset)
        after = ca.densify(transition.reset(t, x, p))
        slopes = [after, ca.densify(ca.jacobian(after, x)), ca.densify(ca.jacobian(after, t))]
        guards = {
            item.name: Surface.of(f"guard of '{item.name}'", item.guard, item.direction, item.dead_time)
            for item in leaving
        }
        margins = () if domain.admissibility is None else (Surface.of("admissibility", domain.admissibility, 1),)
        return cls(
            domain=domain,
            transition=transition,
            field=ExplicitField.of(domain),
            exit=guards[transition.name],
            others=tuple(guard for name, guard in guards.items() if name != transition.name),
            margins=margins,
            reset=record(ca.Function("reset", [t, x, p], slopes)),
            parameters=tuple(arb(float(value)) for value in domain.parameters),
        )


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
                    raise ProofError(f"the {other.name} may fire {_place(leg, clock)}")
            _require_margins(leg, clock, done)
        except (StepError, *NOT_ENCLOSED) as error:
            raise ProofError(f"{error} {_place(leg, clock)}") from None
        here = here.moved(done.image, done.slope)
        clock, taken = clock + done.length, [*taken, done.length]
        if last:
            if not _rises(leg.exit, leg, clock - done.length, done):
                raise ProofError(f"the {leg.exit.name} may be crossed more than once {_place(leg, clock)}")
            after, duration = _cross(leg, clock, here)
            return Arc(after, taken, duration)
    raise ProofError(f"{most} steps were not enough {_place(leg, clock)}")


def _fitting_step(
    leg: Leg, clock: arb, here: MovingSet, wish: arb, order: int, tolerance: float
) -> tuple[Step, arb]:
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
    return bool(value < 0) or bool(value > 0) or bool(_rate(leg, during, done.tube, along, drift) < 0)


def _rises(guard: Surface, leg: Leg, clock: arb, done: Step) -> bool:
    during = clock.union(clock + done.length)
    _, along, drift = guard.at(during, done.tube, leg.parameters)
    return bool(_rate(leg, during, done.tube, along, drift) > 0)


def _rate(leg: Leg, clock: arb, state: Sequence[arb], along: Sequence[arb], drift: arb) -> arb:
    (rate,) = leg.field.motion(clock, state, 1)[1:]
    return sum((slope * value for slope, value in zip(along, rate, strict=True)), start=drift)


def _require_margins(leg: Leg, clock: arb, done: Step) -> None:
    during = clock.union(clock + done.length)
    for margin in leg.margins:
        value, _, _ = margin.at(during, done.tube, leg.parameters)
        if not value > 0:
            low = value.lower().str(4, radius=False)
            raise ProofError(f"the margin of {margin.name} is only known to be above {low} {_place(leg, clock)}")


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
    raise ProofError(f"the {leg.exit.name} is not crossed transversally {_place(leg, clock)}")


def _root(leg: Leg, clock: arb, done: Step, start: arb) -> arb | None:
    """Newton for the time at which the centre's polynomial meets the guard; not rigorous, and need not be."""
    at = start
    for _ in range(NEWTON_STEPS):
        state = [_polynomial([row[i].mid() for row in done.polynomial], at) for i in range(leg.field.size)]
        value, along, drift = leg.exit.at(clock + at, state, leg.parameters)
        change = (value / _rate(leg, clock + at, state, along, drift)).mid()
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
    value, along, drift = leg.exit.at(during, tube, leg.parameters)
    (rate,) = leg.field.motion(during, tube, 1)[1:]
    speed = sum((slope * change for slope, change in zip(along, rate, strict=True)), start=drift)
    # the centre: it crosses at clock + delay
    middle, _, _ = leg.exit.at(clock, here.centre, leg.parameters)
    delay = -middle / speed
    crossing = [centre + delay * change for centre, change in zip(here.centre, rate, strict=True)]
    image, _, _ = leg.reset([clock + delay], crossing, leg.parameters)
    # every point: slope of state at the crossing, then of the reset
    size = leg.field.size
    _, flat, reset_t = leg.reset([during], tube, leg.parameters)
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
    speed = _rate(leg, clock, hull, along, drift)
    if not speed > 0:
        raise ProofError(f"the {leg.exit.name} is not crossed transversally {_place(leg, clock)}")
    reach = (2 * largest([value]) / speed).upper() + arb(2) ** -200
    for _ in range(TUBE_ATTEMPTS):
        (rate,) = leg.field.motion(clock, hull, 1)[1:]
        tube = [at + symmetric(4 * reach * change.abs_upper() + reach * reach) for at, change in zip(hull, rate, strict=True)]
        during = clock + symmetric(reach)
        (within,) = leg.field.motion(during, tube, 1)[1:]
        held = [at + symmetric(reach * change.abs_upper()) for at, change in zip(hull, within, strict=True)]
        _, along, drift = leg.exit.at(during, tube, leg.parameters)
        speed = _rate(leg, during, tube, along, drift)
        if inside(held, tube) and speed > 0 and largest([value]) < reach * speed.lower():
            return tube, reach
        reach = 2 * reach
    raise ProofError(f"the crossing of the {leg.exit.name} could not be enclosed {_place(leg, clock)}")


def _polynomial(coefficients: Sequence[arb], at: arb) -> arb:
    total = coefficients[-1]
    for value in reversed(coefficients[:-1]):
        total = (total * at + value).mid()
    return total


def _place(leg: Leg, clock: arb) -> str:
    return f"in domain '{leg.domain.name}' at clock {float(clock):.6g} s"


def _symbols(function: ca.Function) -> list[ca.SX]:
    return [ca.SX.sym(name, function.numel_in(i)) for i, name in enumerate(("t", "x", "p"))]
