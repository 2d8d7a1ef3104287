"""Files of proofs with one number moved inward: every claim, as a place in the file and what is put there."""

from __future__ import annotations

from collections.abc import Iterator
from fractions import Fraction

import numpy as np

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
    computed by that share of what is claimed.
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
                place[key] = decimal(computed + share * Fraction(place[key]))
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
    if tree["unstable"] is not None and again.unstable is not None:
        found.append(("unstable", tree, "unstable", again.unstable))
    return found
