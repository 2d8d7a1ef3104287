"""One step of the validated integrator: a high-order enclosure and Taylor polynomials with a proved remainder.

If Z, a box, holds sum_(k<Q) [0,h]^k x_k(X) + [0,h]^Q x_Q(Z), then every motion that starts in X exists on [0, h] and
stays in Z (Nedialkov, Jackson and Pryce 2001, An effective high-order interval method for validating existence and
uniqueness of the solution of an IVP for an ODE; Corliss and Rihm 1996), and

    x(h) in sum_(k<Q) h^k x_k(X) + h^Q x_Q(Z).                                                                  (1)

The same holds for the first variation from V(0) = 1, which is linear: V_Q along Z is G V with G that from V = 1.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

from flint import arb, arb_mat, ctx

from amble.errors import WorkError
from amble.proof.arithmetic import between, horner, identity, inside, largest, row_sum_norm, symmetric
from amble.proof.tape import NOT_ENCLOSED, Tape
from amble.proof.taylor import Coefficients, Smooth, variation

INFLATIONS = 4
MOST_STEPS = 2000
"""Of a domain, in a proof and its file."""


class StepError(WorkError):
    """No step length was found at which the enclosure holds."""


@dataclass(frozen=True, kw_only=True)
class Part:
    """A stretch of a step and what holds every motion from the start box all along it.

    Attributes:
        during: clocks, s.
        box: states, n_x balls.
        rate: of the states.
        solution: of the equations that the field solves; empty where it solves none.
    """

    during: arb
    box: list[arb]
    rate: list[arb]
    solution: list[arb]


@dataclass(frozen=True, kw_only=True)
class Step:
    """What one step proves.

    Attributes:
        length: h, exact, s.
        parts: of the step, in order; together they cover it.
        centre: every state's coefficients of a polynomial close to the motion of the centre.
        image: of the centre at h.
        slope: dx(h)/dx(0) for every start in the box.
        error: bound of what the step adds to the image.
    """

    length: arb
    parts: tuple[Part, ...]
    centre: list[list[arb]]
    image: list[arb]
    slope: arb_mat
    error: arb


class Field(Protocol):
    """A vector field through which sets can be followed."""

    @property
    def size(self) -> int:
        """Number of states."""

    @property
    def governing(self) -> tuple[Tape, ...]:
        """The expressions that determine the motion, over (t, x, p)."""

    def part(self, during: arb, box: Sequence[arb]) -> Part:
        """Return what holds in a small box of states at some clocks."""

    def slope(self, part: Part) -> arb_mat:
        """Return balls that hold f_x there."""

    def drift(self, part: Part) -> list[arb]:
        """Return balls that hold f_t there."""

    def polynomial(self, clock: arb, centre: Sequence[arb], order: int) -> list[list[arb]]:
        """Return every state's coefficients of the motion from a point, as far as the order."""

    def step(self, clock: arb, centre: Sequence[arb], box: Sequence[arb], length: arb, order: int) -> Step:
        """Advance a box of starts with a point of it, its exact centre, by a step.

        Raises:
            StepError: no enclosure was found.
        """


def take_step(field: Smooth, clock: arb, centre: Sequence[arb], box: Sequence[arb], length: arb, order: int) -> Step:
    """Advance a box with its centre by a step.

    Args:
        field: the vector field.
        clock: of the start, exact, s.
        centre: a point of the box, exact.
        box: the starts.
        length: h, exact, s.
        order: Q.

    Raises:
        StepError: no enclosure was found.
    """
    motion = field.motion(clock, box, order)
    tube = _enclosure(field, clock, motion, length, order)
    passed = None if tube is None else _variational(field, clock, motion, tube, length, order)
    if tube is None or passed is None:
        raise StepError(f"no enclosure of the motion at clock {clock.str(6, radius=False)} s")
    rows = [*field.motion(clock, centre, order - 1), tube.remainder]
    polynomial = [[row[i] for row in rows] for i in range(field.size)]
    whole = Part(during=between(clock, clock + length), box=tube.box, rate=tube.motion[1], solution=[])
    return Step(
        length=length,
        parts=(whole,),
        centre=polynomial,
        image=[horner(row, length) for row in polynomial],
        slope=passed,
        error=largest(tube.remainder) * length**order,
    )


@dataclass(frozen=True)
class _Tube:
    box: list[arb]
    motion: Coefficients

    @property
    def remainder(self) -> list[arb]:
        return self.motion[-1]


def _enclosure(field: Smooth, clock: arb, motion: Coefficients, length: arb, order: int) -> _Tube | None:
    """Find the box Z and its coefficients; None where the guess does not hold itself."""
    span = between(arb(0), length)
    during = between(clock, clock + length)
    last = length**order
    polynomial = [horner([row[i] for row in motion[:order]], span) for i in range(field.size)]
    scale = largest(value - value.mid() for value in polynomial) + arb(2) ** (-4 * ctx.prec)  # 0 where all is exact
    slack = [4 * last * largest([value]) + scale / 2**20 for value in motion[order]]
    for _ in range(INFLATIONS):
        box = [value + symmetric(extra) for value, extra in zip(polynomial, slack, strict=True)]
        try:
            along = field.motion(during, box, order)
        except NOT_ENCLOSED:
            return None
        reached = [value + span**order * remainder for value, remainder in zip(polynomial, along[order], strict=True)]
        if inside(reached, box):
            return _Tube(reached, along)
        slack = [4 * (last * largest([value]) + extra) for value, extra in zip(along[order], slack, strict=True)]
        if not all(value.is_finite() for value in slack):
            return None
    return None


def _variational(
    field: Smooth, clock: arb, motion: Coefficients, tube: _Tube, length: arb, order: int
) -> arb_mat | None:
    """Return dx(h)/dx(0), by equation (1) for V; None where its enclosure does not hold itself."""
    size, one = field.size, identity(field.size)
    powers = variation(field.slopes(clock, motion[:order]), one, order - 1)
    during = between(clock, clock + length)
    remainder = variation(field.slopes(during, tube.motion[:order]), one, order)[order]
    span = between(arb(0), length)
    known = horner(powers, span)
    step = remainder * length**order
    # V in known + [0,1] step V: the largest entry of |V - known| is at most |step| |known| / (1 - |step|), by columns
    gain = row_sum_norm(step)
    if not gain < arb(0.5):
        return None
    extra = symmetric(gain * largest(known.entries()) / (1 - gain))
    around = arb_mat(size, size, [value + extra for value in known.entries()])
    return horner(powers, length) + step * around
