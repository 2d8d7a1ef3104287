"""A proof as a file: every enclosed number as a pair of decimal strings rounded outward, and the check of such a file.

The file holds what a search found (box, steps, W, rate) and what follows from it. Verification computes every enclosure
anew from the former, without a search and in another precision, and asks that each stored number holds the new one: a
number that was moved inward excludes what is computed, and is refused by name.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Literal

import flint
import numpy as np
from flint import arb
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from amble.errors import InputError
from amble.hybrid import HybridSystem
from amble.io.reader import read_json
from amble.io.storage import atomic_write, dumps
from amble.progress import Progress
from amble.proof.arc import ProofError
from amble.proof.arithmetic import decimals, fraction, working_precision
from amble.proof.orbit import (
    Basin,
    ProvedOrbit,
    contraction_on_ball,
    prove_basin,
    prove_orbit,
    refined,
)
from amble.proof.return_map import ReturnMap
from amble.stability.fixed_point import fixed_point
from amble.types import Vector
from amble.version import __version__

OTHER_PRECISION = 53
"""Bits by which verification's precision differs from the proof's."""

OUTWARD = arb(2) ** -20
"""Share of its radius by which a ball is widened before it is written: radii are rounded to 30 bits, differently in
another precision."""

Decimal = Annotated[str, Field(pattern=r"^-?\d{1,60}(e-?\d{1,5})?$")]
Dyadic = Annotated[str, Field(pattern=r"^-?\d{1,200}p-?\d{1,5}$")]
Pair = tuple[Decimal, Decimal]


class _Part(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class Found(_Part):
    """What the search found: enough to compute the rest without one.

    Attributes:
        order: Q of the Taylor steps.
        bits: of the arithmetic.
        centre: c of the box, exact numbers "mantissa p exponent" of base 2.
        radii: of the box.
        steps: of every domain in order, s.
        weight: W.
        rate: r, at most the spectral radius of the quotient's derivative; null where stability is not claimed.
        basin_weight: W of the basin.
        basin_size: of the ball in its norm; null where none is claimed.
        basin_steps: for the ball.
    """

    order: int = Field(ge=2, le=60)
    bits: int = Field(ge=53, le=4096)
    centre: list[Dyadic]
    radii: list[Dyadic]
    steps: list[list[Dyadic]]
    weight: list[list[float]]
    rate: float | None
    basin_weight: list[list[float]]
    basin_size: float | None
    basin_steps: list[list[Dyadic]]


class Proved(_Part):
    """What is proved: balls as pairs of decimal numbers.

    Attributes:
        state: of the fixed point, by name.
        shift: how far a cycle moves, by symmetry.
        durations: of the domains, s.
        multipliers: real and imaginary parts; empty where they could not be separated.
        unstable: lower bound of the spectral radius where it is above 1.
        basin_rate: contraction in every cycle on the basin.
        basin_extent: how far the basin reaches in every coordinate of the quotient.
    """

    state: dict[str, Pair]
    shift: dict[str, Pair]
    durations: list[Pair]
    multipliers: list[tuple[Pair, Pair]]
    unstable: Decimal | None
    basin_rate: float | None
    basin_extent: list[float]


class Proof(_Part):
    """The file.

    Attributes:
        format: what it is.
        version: of the format.
        system: SHA-256 of the expressions, their constants and the parameters.
        software: versions.
        found: what verification starts from.
        proved: what it must come to.
    """

    format: Literal["amble proof"] = "amble proof"
    version: Literal[1] = 1
    system: str
    software: dict[str, str]
    found: Found
    proved: Proved

    @property
    def stable(self) -> bool:
        """Whether exponential stability is proved."""
        return self.found.rate is not None


@dataclass(frozen=True, kw_only=True)
class Settings:
    """How hard to try.

    Attributes:
        bits: of the arithmetic.
        order: of the Taylor steps.
        tolerance: size of a step's remainder that the step length aims at.
        radius: of the box about the fixed point.
        basin: the largest change of a coordinate that is tried for the basin; 0 for no basin.
    """

    bits: int = 128
    order: int = 20
    tolerance: float = 1e-24
    radius: float = 1e-17
    basin: float = 1e-2


def prove(
    system: HybridSystem, guess: Vector, settings: Settings | None = None, progress: Progress | None = None
) -> Proof:
    """Prove a periodic orbit of a hybrid system and what can be proved of its stability.

    Args:
        system: given by casadi expressions.
        guess: state at the entry of the first domain near the fixed point, (n_x,).
        settings: how hard to try.
        progress: called after every pass through the cycle.

    Raises:
        InputError: the system holds compiled code, symmetries that are no translations, or simultaneous guards.
        ProofError: existence could not be proved, and why.
    """
    chosen = settings or Settings()
    start = fixed_point(system, np.asarray(guess, dtype=np.float64), progress=progress).state
    with working_precision(chosen.bits):
        prepared = ReturnMap.of(system, chosen.order, chosen.tolerance)
        centre = refined(prepared, start, chosen.radius * 1e-3, progress)
        orbit = prove_orbit(prepared, centre, [arb(chosen.radius)] * len(centre))
        basin = None
        if orbit.stable and chosen.basin > 0.0:
            basin = prove_basin(prepared, orbit, chosen.basin, progress)
        return _proof(prepared, orbit, basin, chosen.bits)


def verify(proof: Proof, system: HybridSystem) -> None:
    """Compute every enclosure of a proof anew, in another precision and without a search.

    Args:
        proof: read from a file.
        system: that it speaks of.

    Raises:
        InputError: the proof is of another system, or numbers are missing.
        ProofError: what does not follow.
    """
    found, claimed = proof.found, proof.proved
    with working_precision(found.bits + OTHER_PRECISION):
        prepared = ReturnMap.of(system, found.order, 0.0)
        if system_hash(prepared) != proof.system:
            raise InputError("the proof is of another system: the hashes of the expressions differ")
        _expect_shapes(found, system)
        weight = np.array(found.weight)
        again = prove_orbit(
            prepared,
            list(map(_exact, found.centre)),
            list(map(_exact, found.radii)),
            [list(map(_exact, steps)) for steps in found.steps],
            claim=(weight, found.rate),
        )
        new = _orbit_balls(system, again)
        _require("state", claimed.state, new.state)
        _require("shift", claimed.shift, new.shift)
        _require("duration", _numbered(claimed.durations), _numbered(new.durations))
        _require_multipliers(claimed, new)
        if claimed.unstable is not None and (again.unstable is None or Fraction(claimed.unstable) > fraction(again.unstable)):
            raise ProofError("the claimed lower bound of the spectral radius does not follow")
        if found.basin_size is not None:
            steps = [list(map(_exact, steps)) for steps in found.basin_steps]
            rates = (claimed.basin_rate,) if claimed.basin_rate is not None else ()
            ball = contraction_on_ball(prepared, again, np.array(found.basin_weight), found.basin_size, rates, steps)
            if ball is None or claimed.basin_rate is None or not claimed.basin_rate < 1.0:
                raise ProofError("the claimed contraction on the basin does not follow")
            if any(reach > most for reach, most in zip(claimed.basin_extent, ball.extent, strict=True)):
                raise ProofError("the basin does not reach as far as is claimed")


def system_hash(prepared: ReturnMap) -> str:
    """Return the SHA-256 of the operations of all functions with their constants, the parameters and the rules."""
    text = hashlib.sha256()
    for leg in prepared.legs:
        rules = (leg.exit.sign, leg.exit.dead_time, [(other.sign, other.dead_time) for other in leg.others])
        tapes = [*leg.field.tapes, leg.exit.values, leg.reset, *(s.values for s in (*leg.others, *leg.margins))]
        values = [decimals(value) for value in leg.parameters]
        text.update(repr((rules, [tape.listing() for tape in tapes], values, leg.domain.breakpoints)).encode())
    return text.hexdigest()


def save_proof(path: str | Path, proof: Proof) -> Path:
    """Write a proof; errors as in ``amble.io.storage.atomic_write``."""
    return atomic_write(path, dumps(proof.model_dump(mode="json")) + "\n")


def load_proof(path: str | Path) -> Proof:
    """Read a proof.

    Raises:
        InputError: the file is no proof; in one sentence.
    """
    tree = read_json(path, "proof")
    try:
        return Proof.model_validate_json(dumps(tree))
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(str(part) for part in first["loc"])
        raise InputError(f"proof '{path}' cannot be used: {where or 'file'}: {first['msg']}") from None


def _proof(prepared: ReturnMap, orbit: ProvedOrbit, basin: Basin | None, bits: int) -> Proof:
    balls = _orbit_balls(prepared.system, orbit)
    found = Found(
        order=prepared.order,
        bits=bits,
        centre=[_dyadic(value) for value in orbit.centre],
        radii=[_dyadic(value) for value in orbit.radii],
        steps=[[_dyadic(value) for value in steps] for steps in orbit.lengths],
        weight=orbit.weight.tolist(),
        rate=orbit.rate if orbit.stable else None,
        basin_weight=[] if basin is None else basin.weight.tolist(),
        basin_size=None if basin is None else basin.size,
        basin_steps=[] if basin is None else [[_dyadic(value) for value in steps] for steps in basin.lengths],
    )
    proved = balls.model_copy(
        update={
            "basin_rate": None if basin is None else basin.rate,
            "basin_extent": [] if basin is None else [float(value) for value in basin.extent],
        }
    )
    software = {"amble": __version__, "python-flint": flint.__version__}
    return Proof(system=system_hash(prepared), software=software, found=found, proved=proved)


def _orbit_balls(system: HybridSystem, orbit: ProvedOrbit) -> Proved:
    names = [symmetry.name for symmetry in system.symmetries]
    return Proved(
        state={name: _pair(value) for name, value in zip(system.state_names, orbit.state, strict=True)},
        shift={name: _pair(value) for name, value in zip(names, orbit.shift, strict=True)},
        durations=[_pair(value) for value in orbit.durations],
        multipliers=[(_pair(value.real), _pair(value.imag)) for value in orbit.multipliers],
        unstable=None if orbit.unstable is None else decimals(orbit.unstable)[0],
        basin_rate=None,
        basin_extent=[],
    )


def _pair(value: arb) -> Pair:
    wide = value + arb(0, (value.rad() * OUTWARD).upper())
    return decimals(wide)


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


def _require_multipliers(claimed: Proved, new: Proved) -> None:
    if len(claimed.multipliers) not in (0, len(new.multipliers)):
        raise ProofError("the proof has another number of multipliers")
    for number, parts in enumerate(claimed.multipliers):
        for what, pair, other in zip(("real", "imaginary"), parts, new.multipliers[number], strict=True):
            _require(f"{what} part of multiplier", {str(number): pair}, {str(number): other})


def _numbered(pairs: Sequence[Pair]) -> dict[str, Pair]:
    return {str(number): pair for number, pair in enumerate(pairs)}


def _expect_shapes(found: Found, system: HybridSystem) -> None:
    size, count = system.state_size, len(system.symmetries)
    square = len(found.weight) == size - count and all(len(row) == size - count for row in found.weight)
    if not (len(found.centre) == len(found.radii) == size and square and len(found.steps) == len(system.domains)):
        raise InputError("the proof has numbers for another number of states or domains")


def _dyadic(value: arb) -> str:
    mantissa, exponent = value.mid().man_exp()
    return f"{int(mantissa)}p{int(exponent)}"


def _exact(text: str) -> arb:
    mantissa, exponent = text.split("p")
    return arb((int(mantissa), int(exponent)))
