"""A proof beside the certificate: what is estimated, and what is enclosed."""

from __future__ import annotations

from collections.abc import Mapping
from decimal import ROUND_CEILING, Context, Decimal
from typing import TYPE_CHECKING, Any

from amble.report.tables import Table, number
from amble.types import Json

if TYPE_CHECKING:
    from amble.proof import Proof

NOTES = (
    "The certificate estimates, with an error bar; the proof encloses every number, margins all along every motion of "
    "its box. It is read from its file, whose expressions are those of this gait; `amble prove GAIT --verify PROOF` "
    "computes it again.",
)
HEADER = ("quantity", "certificate, estimated", "proof, enclosed")
NONE = "-"
MARGINS = {
    "normal force": "normal force (N)",
    "friction": "friction, mu^2 less the square of what is used",
    "torque": "torque, 1 less the square of the share of its limit",
    "speed": "speed, 1 less the square of the share of its limit",
    "height": "height of swing feet (m)",
    "height of the base": "height of the base above that of a fall (m)",
    "normal impulse": "normal impulse at a landing (N s)",
}
"""Kinds of margins of a gait, in words and units."""


SAYS = "Proved by proof.json, which `amble prove --verify` computes anew and a report does not:"


def proof_table(proof: Proof, stability: Mapping[str, Any] | None) -> Table:
    """Put what is proved of a gait beside what its certificate estimates.

    Args:
        proof: of the gait.
        stability: the stability entries of results.json, where the run has them.
    """
    from amble.proof.sentences import places, rounded_down, rounded_up, up_to_a_turn, whole_rate

    found, proved = proof.found, proof.proved
    if found.rate is not None:
        bound = f"at most {rounded_up(whole_rate(found.rate, proof.half), 6)}"
    else:
        bound = "unstable" if proved.unstable is not None else "not proved to be stable"
    neutral = ", ".join([*proved.shift, *(["turn about the vertical"] if up_to_a_turn(proof) else [])])
    rows = [
        ("spectral radius of the full cycle", _estimate(stability), bound),
        ("stable up to", NONE, neutral or "nothing"),
        ("fixed point, widest coordinate", NONE, _widest(proof)),
        *((f"smallest margin: {MARGINS.get(kind, kind)}", NONE, low) for kind, low in _margins(proof).items()),
    ]
    if proved.basin_rate is not None:
        most, left = max(proved.basin_extent), rounded_up(proved.basin_rate, 4)
        cycle = "half cycle" if proof.half else "cycle"
        rows.append(("basin, in the coordinate that may change most", NONE, rounded_down(most, 3)))
        rows.append((f"of the distance from the orbit left after a {cycle} there", NONE, f"at most {left}"))
    rows += [
        (
            f"missed of the robot record's decimals at {places(proof)} points, {name}",
            NONE,
            f"at most {rounded_up(most, 3)}",
        )
        for name, most in proved.distance.items()
    ]
    return Table("Certificate and proof", HEADER, tuple(rows), NOTES)


def proof_summary(proof: Proof) -> str:
    """Say in a sentence what a proof's file says is proved."""
    from amble.proof.sentences import one_orbit, rounded_up, up_to_a_turn, whole_rate

    if proof.found.rate is None:
        return f"{SAYS} {one_orbit(proof)} in a box; that it is stable is not."
    bound = rounded_up(whole_rate(proof.found.rate, proof.half), 5)
    turned = " up to a turn about the vertical" if up_to_a_turn(proof) else ""
    return (
        f"{SAYS} {one_orbit(proof)} in a box, exponentially stable{turned}, with a spectral radius of the "
        f"full cycle of at most {bound}; its contacts and limits hold all along it."
    )


def proof_results(proof: Proof) -> Json:
    """Return what results.json says of a proof."""
    return {"proof": {"system": proof.system, "half": proof.half, "rate": proof.found.rate, "stable": proof.stable}}


def _estimate(stability: Mapping[str, Any] | None) -> str:
    if stability is None:
        return NONE
    radius = stability["spectral_radius"]
    return f"{number(float(radius['stabilized']))}, error bar {number(float(radius['error']), 2)}"


def _widest(proof: Proof) -> str:
    from amble.proof.sentences import rounded_up

    upward = Context(prec=28, rounding=ROUND_CEILING)
    widths = [upward.subtract(Decimal(high), Decimal(low)) for low, high in proof.proved.state.values()]
    return rounded_up(str(max(widths)), 2)


def _margins(proof: Proof) -> dict[str, str]:
    """Of every kind of margin the smallest, and of what it is."""
    from fractions import Fraction

    from amble.proof.sentences import rounded_down

    found: dict[str, tuple[Fraction, str]] = {}
    for margins in proof.proved.margins:
        for name, low in margins.items():
            kind, _, whose = name.partition(" of '")
            value = Fraction(low), f"{rounded_down(low, 3)}{f' ({whose.rstrip(chr(39))})' if whose else ''}"
            found[kind] = min(found.get(kind, value), value)
    return {kind: text for kind, (_, text) in found.items()}
