"""Verification of a proof's file: every enclosure is computed anew, in another precision and without a search.

Each stored number must hold the new one; one that was moved inward excludes what is computed, and is refused by name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction

import numpy as np
from flint import arb

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.hybrid import HybridSystem
from amble.proof.arithmetic import fraction, working_precision
from amble.proof.basin import contraction_on_ball
from amble.proof.errors import ProofError
from amble.proof.gait_map import gait_map, require_provable
from amble.proof.orbit import ProvedOrbit, prove_orbit
from amble.proof.record import Found, Pair, Proof, Proved, orbit_balls, system_hash
from amble.proof.return_map import ReturnMap
from amble.stability.closed_loop_orbit import without_yaw

OTHER_PRECISION = 53
"""Bits by which verification's precision differs from the proof's."""


def verify(proof: Proof, system: HybridSystem | Gait) -> None:
    """Compute every enclosure of a proof anew, in another precision and without a search.

    Args:
        proof: read from a file.
        system: that it speaks of, or the gait whose closed loop it speaks of.

    Raises:
        InputError: the proof is of another system, or numbers are missing.
        ProofError: what does not follow.
    """
    found, claimed = proof.found, proof.proved
    with working_precision(found.bits + OTHER_PRECISION):
        prepared = _prepared(system, found.order)
        half = isinstance(system, Gait) and system.pattern.mirrored
        system = prepared.system
        if system_hash(prepared) != proof.system or half != proof.half:
            raise InputError("the proof is of another system: the hashes of the expressions differ")
        _expect_shapes(found, claimed, system)
        weight = np.array(found.weight)
        again = prove_orbit(
            prepared,
            list(map(_exact, found.centre)),
            list(map(_exact, found.radii)),
            [list(map(_exact, steps)) for steps in found.steps],
            claim=(weight, found.rate),
        )
        new = orbit_balls(system, again)
        _require("state", claimed.state, new.state)
        _require("shift", claimed.shift, new.shift)
        _require("duration", _numbered(claimed.durations), _numbered(new.durations))
        _require_margins(claimed, again)
        _require_multipliers(claimed, new)
        bound = None if again.unstable is None else fraction(again.unstable.lower())
        if claimed.unstable is not None and (bound is None or Fraction(claimed.unstable) > bound):
            raise ProofError("the claimed lower bound of the spectral radius does not follow")
        if found.basin_size is not None:
            steps = [list(map(_exact, steps)) for steps in found.basin_steps]
            rates = (claimed.basin_rate,) if claimed.basin_rate is not None else ()
            ball = contraction_on_ball(prepared, again, np.array(found.basin_weight), found.basin_size, rates, steps)
            if ball is None or claimed.basin_rate is None or not claimed.basin_rate < 1.0:
                raise ProofError("the claimed contraction on the basin does not follow")
            if any(reach > most for reach, most in zip(claimed.basin_extent, ball.extent, strict=True)):
                raise ProofError("the basin does not reach as far as is claimed")


def _require(what: str, claimed: Mapping[str, Pair], new: Mapping[str, Pair]) -> None:
    """Ask that every claimed ball holds the new one, less the widening of both."""
    if claimed.keys() != new.keys():
        raise ProofError(f"the proof lacks a {what} or has one too many")
    for name, pair in claimed.items():
        low, high = map(Fraction, pair)
        under, over = map(Fraction, new[name])
        slack = (over - under) * Fraction(1, 2**19)
        if low > under + slack or high < over - slack:
            raise ProofError(f"the claimed {what} '{name}' does not hold what is computed")


def _prepared(system: HybridSystem | Gait, order: int) -> ReturnMap:
    if isinstance(system, HybridSystem):
        return ReturnMap.of(system, order, 0.0)
    require_provable(system)
    return gait_map(system, without_yaw(closed_loop(system, half=True), system.pattern.mirrored), order, 0.0)


def _require_margins(claimed: Proved, again: ProvedOrbit) -> None:
    if [margins.keys() for margins in claimed.margins] != [margins.keys() for margins in again.margins]:
        raise ProofError("the proof has other margins than the system")
    for number, margins in enumerate(claimed.margins):
        for name, low in margins.items():
            if not 0 < Fraction(low) <= fraction(again.margins[number][name]):
                raise ProofError(f"the claimed margin of {name} does not follow")


def _require_multipliers(claimed: Proved, new: Proved) -> None:
    if len(claimed.multipliers) not in (0, len(new.multipliers)):
        raise ProofError("the proof has another number of multipliers")
    for number, parts in enumerate(claimed.multipliers):
        for what, pair, other in zip(("real", "imaginary"), parts, new.multipliers[number], strict=True):
            _require(f"{what} part of multiplier", {str(number): pair}, {str(number): other})


def _numbered(pairs: Sequence[Pair]) -> dict[str, Pair]:
    return {str(number): pair for number, pair in enumerate(pairs)}


def _expect_shapes(found: Found, claimed: Proved, system: HybridSystem) -> None:
    size, domains = system.state_size - len(system.symmetries), len(system.domains)
    fits = len(found.centre) == len(found.radii) == system.state_size and len(found.steps) == domains
    if not (fits and _square(found.weight, size)):
        raise InputError("the proof has numbers for another number of states or domains")
    if found.basin_size is None:
        return
    if not (_square(found.basin_weight, size) and len(found.basin_steps) == domains):
        raise InputError("the basin of the proof has numbers for another number of states or domains")
    weight = np.array(found.basin_weight)
    definite = np.array_equal(weight, weight.T) and float(np.linalg.eigvalsh(weight)[0]) > 0.0
    if not (definite and len(claimed.basin_extent) in (size, system.state_size)):
        raise InputError("the basin of the proof has no W that is positive definite, or too few extents")


def _square(rows: list[list[float]], size: int) -> bool:
    return len(rows) == size and all(len(row) == size for row in rows)


def _exact(text: str) -> arb:
    mantissa, exponent = text.split("p")
    return arb((int(mantissa), int(exponent)))
