"""What a proof is of, as a hash: all that its motions, margins, resets, symmetries and names depend on.

The prepared system is written out attribute by attribute, by what its records hold, so that an attribute that comes
later is in the hash too, and what cannot be written ends the work. Not in it is what the file of a proof says itself:
order, tolerance, precision.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import fields, is_dataclass
from typing import Any

import casadi as ca
from flint import arb

from amble.hybrid import Symmetry
from amble.proof.leg import Leg
from amble.proof.return_map import ReturnMap
from amble.proof.tape import Tape, expression, record


def system_hash(prepared: ReturnMap) -> str:
    """Return the SHA-256 of a prepared system; tapes are in it by their operations and constants.

    Raises:
        InputError: a symmetry is compiled code, or holds an operation without an enclosure.
    """
    system, digests = prepared.system, dict[int, str]()
    symmetries = [(symmetry.name, generator(symmetry)) for symmetry in system.symmetries]
    whole = [
        list(system.state_names),
        [[name, _digest(tape)] for name, tape in symmetries],
        [_digest(tape) for tape in prepared.turns],
        prepared.record,
        [_leg(leg, digests) for leg in prepared.legs],
    ]
    return hashlib.sha256(json.dumps(whole).encode()).hexdigest()


def generator(symmetry: Symmetry) -> Tape:
    """Return the tape of a symmetry's generator, over x."""
    x = ca.SX.sym("x", symmetry.generator.numel_in(0))
    return record(ca.Function("generator", [x], [expression(symmetry.generator, [x])]))


def _leg(leg: Leg, digests: dict[int, str]) -> list[Any]:
    """Write a domain: of what it was prepared from, ``Leg.domain``, the breakpoints alone are looked at later."""
    prepared = [getattr(leg, part.name) for part in fields(leg) if part.name != "domain"]
    return [_written(value, digests) for value in (leg.domain.breakpoints, *prepared)]


def _written(value: Any, digests: dict[int, str]) -> Any:
    """Write a value as lists of text and whole numbers, numbers exactly.

    Args:
        value: of a record.
        digests: of tapes that were met, by identity: stretches share theirs.
    """
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, float):
        return value.hex()
    if isinstance(value, arb):
        return _ball(value)
    if isinstance(value, Tape):
        if id(value) not in digests:
            digests[id(value)] = _digest(value)
        return digests[id(value)]
    if isinstance(value, list | tuple):
        return [_written(entry, digests) for entry in value]
    if is_dataclass(value):
        return [_written(getattr(value, part.name), digests) for part in fields(value)]
    raise TypeError(f"what a proof depends on holds a {type(value).__name__}, which is not written")


def _ball(value: arb) -> list[str]:
    ends = (value.mid(), value.rad())
    return [str(end) if not end.is_finite() else " ".join(map(str, end.man_exp())) for end in ends]


def _digest(tape: Tape) -> str:
    return hashlib.sha256(tape.listing().encode()).hexdigest()
