"""Verification of a proof's file: every enclosure is computed anew, in another precision and without a search.

Each stored number must hold the new one; one that was moved inward excludes what is computed, and is refused by name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction

import numpy as np
from flint import arb

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.hybrid import HybridSystem
from amble.progress import Progress, silent
from amble.proof.arithmetic import fraction, working_precision
from amble.proof.basin import Basin, contraction_on_ball
from amble.proof.errors import ProofError
from amble.proof.gait_map import gait_map, require_provable, require_smooth
from amble.proof.identity import system_hash
from amble.proof.orbit import ProvedOrbit, prove_orbit
from amble.proof.record import Found, Pair, Proof, Proved, orbit_balls
from amble.proof.record_distance import distances
from amble.proof.return_map import ReturnMap
from amble.stability.closed_loop_orbit import without_yaw

OTHER_PRECISION = 53
"""Bits by which verification's precision differs from the proof's."""


@dataclass(frozen=True, kw_only=True)
class Recomputed:
    """What follows from what a proof's file starts from.

    Attributes:
        orbit: every enclosure of it.
        balls: the same as a file holds them, without room.
        margins: of every domain, name -> lower bound.
        unstable: lower bound of the spectral radius where it is above 1.
        basin: on which the claimed rate holds; None where none is claimed.
        distance: of a gait's expressions from its robot record's decimals, what is missed -> upper bound.
    """

    orbit: ProvedOrbit
    balls: Proved
    margins: tuple[Mapping[str, Fraction], ...]
    unstable: Fraction | None
    basin: Basin | None
    distance: Mapping[str, Fraction]


def verify(proof: Proof, system: HybridSystem | Gait, progress: Progress = silent) -> None:
    """Compute every enclosure of a proof anew, in another precision and without a search.

    Args:
        proof: read from a file.
        system: that it speaks of, or the gait whose closed loop it speaks of.
        progress: called after every step.

    Raises:
        InputError: the proof is of another system, or numbers are missing.
        ProofError: what does not follow.
    """
    require_claims(proof.proved, recomputed(proof, system, progress))


def require_same(proof: Proof, system: HybridSystem | Gait) -> None:
    """Ask that a proof is of a system and has a number for all that it speaks of; whether they follow is not looked at.

    Raises:
        InputError: it is of another system, lacks numbers, or there is no proof of this one.
    """
    with working_precision(proof.found.bits):
        prepared = _same(proof, system)
        _expect_shapes(proof.found, proof.proved, prepared)
        whole = prepared.system
        claimed = [*proof.proved.state, *proof.proved.shift]
        if not proof.proved.state or not set(claimed) <= set(whole.state_names):
            raise InputError("the proof has numbers for other states than the system's")
        if len(proof.proved.margins) != len(whole.domains):
            raise InputError("the proof has margins for another number of domains")


def recomputed(proof: Proof, system: HybridSystem | Gait, progress: Progress = silent) -> Recomputed:
    """Compute what follows from the box, the steps and the weights of a proof; errors as in ``verify``."""
    found, claimed = proof.found, proof.proved
    with working_precision(found.bits + OTHER_PRECISION):
        prepared = replace(_same(proof, system), progress=progress)
        _expect_shapes(found, claimed, prepared)
        if isinstance(system, Gait):  # the durations claimed hold those of the orbit, as is seen later
            require_smooth(prepared, [float(Fraction(high)) for _, high in claimed.durations])
        orbit = prove_orbit(
            prepared,
            list(map(_exact, found.centre)),
            list(map(_exact, found.radii)),
            [list(map(_exact, steps)) for steps in found.steps],
            claim=(np.array(found.weight), found.rate),
        )
        return Recomputed(
            orbit=orbit,
            balls=orbit_balls(prepared.system, orbit),
            margins=tuple({name: fraction(low) for name, low in margins.items()} for margins in orbit.margins),
            unstable=None if orbit.unstable is None else fraction(orbit.unstable.lower()),
            basin=_basin(prepared, orbit, proof),
            distance=_distance(prepared, orbit, system),
        )


def require_claims(claimed: Proved, again: Recomputed) -> None:
    """Ask that all that a file says is proved follows.

    Args:
        claimed: what it says.
        again: what follows from what it starts from.

    Raises:
        ProofError: what does not follow.
    """
    new = again.balls
    _require("state", claimed.state, new.state)
    _require("shift", claimed.shift, new.shift)
    _require("duration", _numbered(claimed.durations), _numbered(new.durations))
    _require_margins(claimed, again)
    _require_multipliers(claimed, new)
    if claimed.unstable is not None and (again.unstable is None or Fraction(claimed.unstable) > again.unstable):
        raise ProofError("the claimed lower bound of the spectral radius does not follow")
    extent = () if again.basin is None else again.basin.extent
    if not all(reach <= most for reach, most in zip(claimed.basin_extent, extent, strict=True)):
        raise ProofError("the basin does not reach as far as is claimed")
    if claimed.distance.keys() != again.distance.keys():
        raise ProofError("the proof lacks a distance from the robot record or has one too many")
    for name, most in claimed.distance.items():
        if Fraction(most) < again.distance[name]:
            raise ProofError(f"the claimed distance from the robot record, {name}, does not follow")


def _distance(prepared: ReturnMap, orbit: ProvedOrbit, system: HybridSystem | Gait) -> dict[str, Fraction]:
    if isinstance(system, HybridSystem):
        return {}
    return {name: fraction(most) for name, most in distances(system, system.robot, prepared, orbit, room=False).items()}


def _basin(prepared: ReturnMap, orbit: ProvedOrbit, proof: Proof) -> Basin | None:
    """Prove the claimed contraction."""
    found, rate = proof.found, proof.proved.basin_rate
    if found.basin_size is None or rate is None:
        return None
    steps = [list(map(_exact, steps)) for steps in found.basin_steps]
    try:
        return contraction_on_ball(prepared, orbit, np.array(found.basin_weight), found.basin_size, (rate,), steps)
    except ProofError as error:
        raise ProofError(f"the claimed contraction on the basin does not follow: {error}") from None


def _holds(pair: Pair, new: Pair) -> bool:
    """Whether a claimed ball holds a new one."""
    (low, high), (under, over) = map(Fraction, pair), map(Fraction, new)
    return low <= under and over <= high


def _require(what: str, claimed: Mapping[str, Pair], new: Mapping[str, Pair]) -> None:
    """Ask that every claimed ball holds the new one."""
    if claimed.keys() != new.keys():
        raise ProofError(f"the proof lacks a {what} or has one too many")
    for name, pair in claimed.items():
        if not _holds(pair, new[name]):
            raise ProofError(f"the claimed {what} '{name}' does not hold what is computed")


def _same(proof: Proof, system: HybridSystem | Gait) -> ReturnMap:
    """Prepare a system for enclosures, and hold its expressions against those that a proof is of."""
    prepared = _prepared(system, proof.found.order)
    half = isinstance(system, Gait) and system.pattern.mirrored
    if system_hash(prepared) != proof.system or half != proof.half:
        raise InputError("the proof is of another system: the hashes of the expressions differ")
    return prepared


def _prepared(system: HybridSystem | Gait, order: int) -> ReturnMap:
    if isinstance(system, HybridSystem):
        return ReturnMap.of(system, order, 0.0)
    require_provable(system)
    return gait_map(system, without_yaw(closed_loop(system, half=True), system.pattern.mirrored), order, 0.0)


def _require_margins(claimed: Proved, again: Recomputed) -> None:
    if [margins.keys() for margins in claimed.margins] != [margins.keys() for margins in again.margins]:
        raise ProofError("the proof has other margins than the system")
    for number, margins in enumerate(claimed.margins):
        for name, low in margins.items():
            if not 0 < Fraction(low) <= again.margins[number][name]:
                raise ProofError(f"the claimed margin of {name} does not follow")


def _require_multipliers(claimed: Proved, new: Proved) -> None:
    """Ask that every claimed ball holds one of the new ones, each another: their order and number are no claim."""
    left = list(new.multipliers)
    for number, parts in enumerate(claimed.multipliers):
        held = next((ball for ball in left if all(map(_holds, parts, ball))), None)
        if held is None:
            raise ProofError(f"the claimed multiplier {number} does not hold what is computed")
        left.remove(held)


def _numbered(pairs: Sequence[Pair]) -> dict[str, Pair]:
    return {str(number): pair for number, pair in enumerate(pairs)}


def _expect_shapes(found: Found, claimed: Proved, prepared: ReturnMap) -> None:
    system = prepared.system
    size, domains = system.state_size - len(system.symmetries) - len(prepared.turns), len(system.domains)
    fits = len(found.centre) == len(found.radii) == system.state_size and len(found.steps) == domains
    if not (fits and len(claimed.durations) == domains and _square(found.weight, size)):
        raise InputError("the proof has numbers for another number of states or domains")
    if found.basin_size is None:
        return
    if not (_square(found.basin_weight, size) and len(found.basin_steps) == domains):
        raise InputError("the basin of the proof has numbers for another number of states or domains")
    weight = np.array(found.basin_weight)
    definite = np.array_equal(weight, weight.T) and float(np.linalg.eigvalsh(weight)[0]) > 0.0
    if not (definite and len(claimed.basin_extent) == size):
        raise InputError("the basin of the proof has no W that is positive definite, or another number of extents")


def _square(rows: list[list[float]], size: int) -> bool:
    return len(rows) == size and all(len(row) == size for row in rows)


def _exact(text: str) -> arb:
    mantissa, exponent = text.split("p")
    return arb((int(mantissa), int(exponent)))
