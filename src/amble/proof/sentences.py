"""What a proof says, in sentences; bounds are rounded outward, so that what is printed is proved too."""

from __future__ import annotations

from decimal import ROUND_CEILING, ROUND_FLOOR, Context, Decimal
from math import nextafter

from amble.proof.record import Proof
from amble.proof.record_distance import FORCE, MOMENT, PLACE


def sentences(proof: Proof) -> list[str]:
    """Say what is proved, and what is not."""
    lines = [f"proved: {one_orbit(proof)} passes the box"]
    lines += [f"  {name} in [{low}, {high}]" for name, (low, high) in proof.proved.state.items()]
    if proof.found.rate is not None:
        whole = f", of the whole cycle {rounded_up(whole_rate(proof.found.rate, proof.half), 10)}" if proof.half else ""
        what = "half a cycle" if proof.half else "a cycle"
        how = "exponentially stable" + (" up to a turn about the vertical" if up_to_a_turn(proof) else "")
        lines.append(f"proved: {how}, spectral radius of {what} at most {rounded_up(proof.found.rate, 10)}{whole}")
    elif proof.proved.unstable is not None:
        lines.append(f"proved: unstable, a Floquet multiplier of size at least {proof.proved.unstable}")
    else:
        lines.append("not proved: neither stable nor unstable at this precision")
    for number, margins in enumerate(proof.proved.margins):
        if margins:
            lowest = ", ".join(f"{name} {rounded_down(low, 3)}" for name, low in margins.items())
            lines.append(f"proved all along domain {number + 1}: margins of at least {lowest}")
    if proof.proved.basin_rate is not None:
        reach = ", ".join(rounded_down(value, 3) for value in proof.proved.basin_extent)
        left = rounded_up(proof.proved.basin_rate, 4)
        lines.append(
            f"proved: attracts from a ball that reaches ({reach}), with at most {left} of the distance left after "
            f"every {'half of a ' if proof.half else ''}cycle"
        )
    if proof.basin_limit:
        lines.append(f"not proved: a larger basin; {proof.basin_limit}")
    if proof.proved.distance:
        force, moment, place = (rounded_up(proof.proved.distance[name], 3) for name in (FORCE, MOMENT, PLACE))
        lines.append(
            f"bounded in 50 digits at {places(proof)} points along the orbit: by the robot record's decimal numbers "
            f"the model's motion takes at most {force} N and {moment} N m more, and feet are within {place} m"
        )
    return lines


def one_orbit(proof: Proof) -> str:
    """Say what there is one of; orbits that close after more cycles may pass the box too."""
    length = "half a cycle, mirrored," if proof.half else "a cycle"
    shifts = " and ".join(proof.proved.shift)
    return f"exactly one periodic orbit of {length}" + (f" up to {shifts}" if shifts else "")


def whole_rate(rate: float, half: bool) -> float:
    """Return a bound of the spectral radius of the whole cycle."""
    return nextafter(rate**2, 1.0) if half else rate


def up_to_a_turn(proof: Proof) -> bool:
    """Whether the quotient is by a turn about the vertical too."""
    return len(proof.found.weight) < len(proof.found.centre) - len(proof.proved.shift)


def places(proof: Proof) -> int:
    """Return at how many points the distance from the robot record is bounded: starts of steps, and landings."""
    return sum(len(steps) + 1 for steps in proof.found.steps)


def rounded_down(bound: float | str, digits: int) -> str:
    """Write a lower bound in so many digits, rounded down: what is printed is proved too."""
    return f"{Context(digits, ROUND_FLOOR).create_decimal(Decimal(bound)):g}"


def rounded_up(bound: float | str, digits: int) -> str:
    """Write an upper bound in so many digits, rounded up."""
    return f"{Context(digits, ROUND_CEILING).create_decimal(Decimal(bound)):g}"
