"""A proof as a file: every enclosed number as a pair of decimal strings rounded outward, and the check of such a file.

The file holds what a search found (box, steps, W, rate) and what follows from it. Verification computes every enclosure
anew from the former, without a search and in another precision, and asks that each stored number holds the new one: a
number that was moved inward excludes what is computed, and is refused by name.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from fractions import Fraction
from pathlib import Path
from typing import Annotated, Literal

import flint
from flint import arb
from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, TypeAdapter, model_validator

from amble.hybrid import HybridSystem
from amble.io.reader import read_record
from amble.io.storage import atomic_write, dumps
from amble.proof.arithmetic import decimals
from amble.proof.basin import Basin
from amble.proof.errors import ProofError
from amble.proof.identity import system_hash
from amble.proof.orbit import ProvedOrbit
from amble.proof.return_map import ReturnMap
from amble.proof.step import MOST_STEPS
from amble.version import __version__

EXTENT_SHARE = 1.0 - 2.0**-20
"""Of a basin's extent, that is written: it is computed in floating point."""

FORMAT = 4
"""Version of the file."""

LARGEST = 300
"""Power of ten below which numbers of a proof are, so that each of them has a double beside it."""


def _bounded(text: str) -> str:
    """Refuse a number that is written as larger than any of a proof, before a power of it is computed.

    Raises:
        ValueError: it is.
    """
    mantissa, mark, exponent = text.replace("p", "e").partition("e")
    power = int(exponent or 0) * (0.302 if "p" in text else 1.0)
    if mark and len(mantissa) + power > LARGEST:
        raise ValueError(f"larger than 1e{LARGEST}, which no number of a proof is")
    return text


Decimal = Annotated[str, Field(pattern=r"^-?\d{1,200}(e-?\d{1,3})?$"), AfterValidator(_bounded)]
Dyadic = Annotated[str, Field(pattern=r"^-?\d{1,320}p-?\d{1,5}$"), AfterValidator(_bounded)]
"""1024 bits have 309 digits."""


def _ordered(pair: tuple[str, str]) -> tuple[str, str]:
    """Refuse the lower end of a ball above its upper one."""
    if Fraction(pair[0]) > Fraction(pair[1]):
        raise ValueError("the lower end of a ball is above its upper one")
    return pair


Pair = Annotated[tuple[Decimal, Decimal], AfterValidator(_ordered)]

Steps = Annotated[list[Annotated[Dyadic, Field(pattern=r"^[1-9]")]], Field(max_length=MOST_STEPS)]
"""Of a domain: positive; a gait needs about 12, and every one is computed again where a proof is verified."""

MOST_WORK = 5e7
"""Steps x order^2 x bits: verification's work on one system. A gait's proof has 2e6 to 4e6, and takes a minute."""

Entries = Field(max_length=1000)
"""Of what there is one for every state, domain, margin or eigenvalue."""


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

    order: int = Field(ge=4, le=40)
    bits: int = Field(ge=64, le=1024)
    centre: list[Dyadic] = Entries
    radii: list[Dyadic] = Entries
    steps: list[Steps] = Entries
    weight: list[Annotated[list[float], Entries]] = Entries
    rate: Annotated[float, Field(gt=0.0, lt=1.0)] | None
    basin_weight: list[Annotated[list[float], Entries]] = Entries
    basin_size: float | None
    basin_steps: list[Steps] = Entries

    @model_validator(mode="after")
    def _is_no_endless_work(self) -> Found:
        too_much = endless(self.order, self.bits, [*self.steps, *self.basin_steps])
        if too_much:
            raise ValueError(too_much)
        return self


def endless(order: int, bits: int, steps: Sequence[Sequence[object]]) -> str:
    """Say that a proof takes more work than is begun on; empty where it does not.

    Args:
        order: Q of the steps.
        bits: of the arithmetic.
        steps: of every domain, of the box and the basin.
    """
    count = sum(map(len, steps))
    if count * order**2 * bits <= MOST_WORK:
        return ""
    return (
        f"{count} steps of order {order} in {bits} bits are more work than is begun on (steps x order^2 x bits "
        f"up to {MOST_WORK:g})"
    )


class Proved(_Part):
    """What is proved: balls as pairs of decimal numbers.

    Attributes:
        state: of the fixed point, by name.
        shift: how far a cycle moves, by symmetry.
        durations: of the domains, s.
        margins: of every domain, name -> lower bound along the orbit; above zero where a foot that lifts has risen.
        multipliers: real and imaginary parts; empty where they could not be separated.
        unstable: lower bound of the spectral radius where it is above 1.
        basin_rate: contraction in every cycle on the basin.
        basin_extent: how far the basin reaches in every coordinate of the quotient.
        distance: of a gait, what is missed -> upper bound by which its expressions miss the equations of its robot
            record's decimal numbers at points along the orbit (``record_distance``); empty of other systems.
    """

    state: dict[str, Pair] = Entries
    shift: dict[str, Pair] = Entries
    durations: list[Pair] = Entries
    margins: list[Annotated[dict[str, Decimal], Entries]] = Entries
    multipliers: list[tuple[Pair, Pair]] = Entries
    unstable: Decimal | None
    basin_rate: float | None
    basin_extent: list[float] = Entries
    distance: dict[str, Decimal] = Entries


def _readable(version: object) -> object:
    """Refuse other formats by name: in 4 the hash holds all that is proved, in 3 it did not.

    Raises:
        ValueError: it is another.
    """
    if version != FORMAT or isinstance(version, bool):
        stated = version if isinstance(version, int) else "of another kind"
        raise ValueError(f"the format {stated} of the proof is not read, only {FORMAT}: prove again")
    return version


class Proof(_Part):
    """The file.

    Attributes:
        format: what it is.
        version: of the format.
        system: SHA-256 of all that is proved of (``identity``).
        half: whether the cycle is half a gait cycle, closed by the mirror; the full one has the squares as multipliers.
        software: versions.
        found: what verification starts from.
        proved: what it must come to.
        basin_limit: what stopped a larger basin, in a sentence; no claim.
    """

    format: Literal["amble proof"] = "amble proof"
    version: Annotated[Literal[4], BeforeValidator(_readable)] = 4
    system: str
    half: bool = False
    software: dict[str, str] = Entries
    found: Found
    proved: Proved
    basin_limit: str = Field(default="", max_length=1000)

    @model_validator(mode="after")
    def _basin_is_whole_or_not_there(self) -> Proof:
        """A basin that nothing is found for would not be looked at when it is verified."""
        found, proved = self.found, self.proved
        lists = (found.basin_weight, found.basin_steps, proved.basin_extent)
        if found.basin_size is None:
            if proved.basin_rate is not None or any(lists):
                raise ValueError("a basin is claimed, and its size is not there")
        elif proved.basin_rate is None or not all(lists):
            raise ValueError("of the basin something is missing")
        elif not (found.basin_size > 0.0 and 0.0 < proved.basin_rate < 1.0 and min(proved.basin_extent) > 0.0):
            raise ValueError("size, rate and extent of a basin are above 0, and its rate below 1")
        return self

    @property
    def stable(self) -> bool:
        """Whether exponential stability is proved."""
        return self.found.rate is not None


PROOF = TypeAdapter(Proof)


def save_proof(path: str | Path, proof: Proof) -> Path:
    """Write a proof; errors as in ``amble.io.storage.atomic_write``."""
    return atomic_write(path, dumps(proof.model_dump(mode="json")) + "\n")


def load_proof(path: str | Path) -> Proof:
    """Read a proof.

    Raises:
        InputError: the file is no proof; in one sentence.
    """
    return read_record(path, "proof", PROOF)


def proof_of(
    prepared: ReturnMap,
    orbit: ProvedOrbit,
    attracting: tuple[Basin | None, str],
    bits: int,
    distance: Mapping[str, arb],
    half: bool = False,
) -> Proof:
    """Return what was found and proved as a file holds it; ``attracting``: the basin, what stopped a larger one.

    Raises:
        ProofError: it would not be read back, for the work that verification takes.
    """
    basin, limit = attracting
    too_much = endless(prepared.order, bits, [*orbit.lengths, *([] if basin is None else basin.lengths)])
    if too_much:
        raise ProofError(
            f"{too_much}: fewer bits (--bits), another order of the steps (--order) or no basin (--basin 0)"
        )
    balls = orbit_balls(prepared.system, orbit)
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
            "basin_extent": [] if basin is None else [float(value * EXTENT_SHARE) for value in basin.extent],
            "distance": {name: decimals(most, 6)[1] for name, most in distance.items()},
        }
    )
    software = {"amble": __version__, "python-flint": flint.__version__}
    return Proof(
        system=system_hash(prepared), half=half, software=software, found=found, proved=proved, basin_limit=limit
    )


def orbit_balls(system: HybridSystem, orbit: ProvedOrbit) -> Proved:
    """Return what is proved of an orbit as pairs of decimals; no basin, no distance from a robot record."""
    names = [symmetry.name for symmetry in system.symmetries]
    return Proved(
        state={name: decimals(value) for name, value in zip(system.state_names, orbit.state, strict=True)},
        shift={name: decimals(value) for name, value in zip(names, orbit.shift, strict=True)},
        durations=[decimals(value) for value in orbit.durations],
        margins=[{name: decimals(low, 6)[0] for name, low in margins.items()} for margins in orbit.margins],
        multipliers=[(decimals(value.real), decimals(value.imag)) for value in orbit.multipliers],
        unstable=None if orbit.unstable is None else decimals(orbit.unstable)[0],
        basin_rate=None,
        basin_extent=[],
        distance={},
    )


def _dyadic(value: arb) -> str:
    mantissa, exponent = value.mid().man_exp()
    return f"{int(mantissa)}p{int(exponent)}"
