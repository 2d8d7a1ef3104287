"""Files of proofs with one number moved inward: every claim, as a place in the file and what is put there."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np
from flint import arb

from amble.proof import Proof
from amble.proof.verification import Recomputed
from amble.types import Json

ROUNDING = Fraction(1, 10**37)
"""Width below which a ball is a number and the rounding of its decimals."""
SHARES = 0.1, 0.9
"""By which share of its width a ball is moved inward at least and at most; its room is 1/17 of it."""


def altered(proof: Proof, again: Recomputed, draws: np.random.Generator) -> Iterator[tuple[str, Proof]]:
    """Return files without end, every claim in turn, with what was moved.

    An end of a ball is moved by a share of its width. A margin and the bound of an instability are raised above what is
    computed by that share of what is claimed, a distance from the robot record is lowered below it.
    """
    while True:
        tree = proof.model_dump(mode="json")
        for number in draws.permutation(len(_ends(tree["proved"])) + len(_bounds(tree["proved"], again))):
            changed = proof.model_dump(mode="json")
            ends, bounds = _ends(changed["proved"]), _bounds(changed["proved"], again)
            share = Fraction(float(draws.uniform(*SHARES)))
            if number < len(ends):
                what, pair, end = ends[number]
                low, high = map(Fraction, pair)
                inward = share * (high - low)
                pair[end] = decimal(low + inward if end == 0 else high - inward)
            else:
                what, place, key, computed = bounds[number - len(ends)]
                aside = share * Fraction(place[key])  # an upper bound falls, a lower one rises
                place[key] = decimal(computed - aside if what in again.distance else computed + aside)
            yield what, Proof.model_validate(changed, strict=False)


def decimal(value: Fraction) -> str:
    """Write a number with 80 digits behind the point."""
    return f"{round(value * 10**80)}e-80"


def _ends(tree: Json) -> list[tuple[str, list[str], int]]:
    named = [(name, pair) for what in ("state", "shift") for name, pair in tree[what].items()]
    named += [(f"duration {number}", pair) for number, pair in enumerate(tree["durations"])]
    named += [(f"multiplier {number}", part) for number, parts in enumerate(tree["multipliers"]) for part in parts]
    return [(name, pair, end) for name, pair in named for end in (0, 1) if _width(pair) > ROUNDING]


def _width(pair: list[str]) -> Fraction:
    return Fraction(pair[1]) - Fraction(pair[0])


def _bounds(tree: Json, again: Recomputed) -> list[tuple[str, Json, str, Fraction]]:
    found = [
        (f"margin of {name}", margins, name, again.margins[number][name])
        for number, margins in enumerate(tree["margins"])
        for name in margins
    ]
    found += [(name, tree["distance"], name, most) for name, most in again.distance.items()]
    if tree["unstable"] is not None and again.unstable is not None:
        found.append(("unstable", tree, "unstable", again.unstable))
    return found


def searched(
    proof: Proof, again: Recomputed, draws: np.random.Generator, radius: float | None = None
) -> Iterator[tuple[str, Proof]]:
    """Return files in which one thing that was searched is another, each such that what it claims is false.

    The spectral radius is given where the multipliers are not enclosed one by one.

    A rate falls below the spectral radius by a share of what it lies above it; a weight loses its smallest eigenvalue;
    a radius no longer reaches the fixed point, a centre leaves it outside; the last step ends before the guard, or the
    first one is missing; a basin is claimed to reach farther, or to contract faster than its derivative does.
    """
    share, found = float(draws.uniform(*SHARES)), proof.found
    enclosed = [float(abs(value).abs_lower()) for value in again.orbit.multipliers]
    largest = max(enclosed) if radius is None else radius
    off = [abs(value - centre).lower() for value, centre in zip(again.orbit.state, again.orbit.centre, strict=True)]
    farthest = max(range(len(off)), key=lambda number: float(off[number]))
    changes: list[tuple[str, tuple[str | int, ...], object]] = [
        ("a radius", ("found", "radii", farthest), exact(off[farthest] * (1 - share))),
        ("the centre", ("found", "centre", farthest), exact(again.orbit.centre[farthest] + outside(again, farthest))),
    ]
    if found.rate is not None:
        changes.append(("the rate", ("found", "rate"), largest - share * (found.rate - largest)))
        changes.append(("W", ("found", "weight"), singular(found.weight, share)))
    for number, steps in enumerate(again.orbit.lengths):
        shorter = exact(steps[-1] * (1 - share / 2))
        changes.append(("the last step", ("found", "steps", number, len(steps) - 1), shorter))
        changes.append(("no first step", ("found", "steps", number), [exact(length) for length in steps[1:]]))
    if found.basin_size is not None:
        changes.append(("the basin's rate", ("proved", "basin_rate"), largest * (1 - 1e-6 * share)))
        changes.append(("the basin's W", ("found", "basin_weight"), singular(found.basin_weight, share)))
        if proof.basin_limit:
            changes.append(("the basin's size", ("found", "basin_size"), 4.0 * found.basin_size))
        for number, reach in enumerate(proof.proved.basin_extent):
            farther = reach * (1 + 1e-5 * share)
            changes.append((f"extent {number} of the basin", ("proved", "basin_extent", number), farther))
    for what, path, value in changes:
        tree = proof.model_dump(mode="json")
        here = tree
        for key in path[:-1]:
            here = here[key]
        here[path[-1]] = value
        yield what, Proof.model_validate(tree, strict=False)


def exact(value: arb) -> str:
    """Write a number as files have the exact ones."""
    mantissa, exponent = value.mid().man_exp()
    return f"{int(mantissa)}p{int(exponent)}"


def outside(again: Recomputed, number: int) -> arb:
    """Half as much again as the box reaches: the fixed point lies nearer to its centre than half of that."""
    return again.orbit.radii[number] * arb(1.5)


def singular(weight: list[list[float]], share: float) -> list[list[float]]:
    """Take from a matrix its smallest eigenvalue, and a share of that more."""
    matrix = np.array(weight)
    values, vectors = np.linalg.eigh(matrix)
    less = matrix - (1 + share) * values[0] * np.outer(vectors[:, 0], vectors[:, 0])
    return np.asarray(0.5 * (less + less.T)).tolist()
