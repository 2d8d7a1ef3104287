"""Proofs are verified from their files; files with one number moved inward are refused, by what was moved."""

from __future__ import annotations

from fractions import Fraction
from itertools import islice

import numpy as np
import pytest
from examples import rimless_wheel, simplest_walker

from amble.hybrid import HybridSystem
from amble.proof import Proof, ProofError, Settings, prove, verification, verify
from amble.proof.arithmetic import working_precision
from amble.proof.quotient import claimed, quotient, translations
from amble.proof.verification import Recomputed, recomputed, require_claims
from amble.types import Vector
from tests.proof import gaits
from tests.proof.altered import altered

SETTINGS = Settings(order=14, tolerance=1e-22, radius=1e-15, basin=0.0)


def wheel() -> tuple[HybridSystem, Vector]:
    return rimless_wheel.rolling()


@pytest.mark.parametrize("walker", [wheel, pytest.param(simplest_walker.short_step, marks=pytest.mark.slow)])
def test_a_hundred_files_of_a_walker(walker: type[wheel]) -> None:  # type: ignore[valid-type]
    system, start = walker()
    proof = prove(system, start, SETTINGS)
    again = recomputed(proof, system)
    require_claims(proof.proved, again)
    refused_all(proof, again)
    with pytest.raises(ProofError):  # and by the whole of verification
        verify(next(altered(proof, again, np.random.default_rng(1)))[1], system)


def refused_all(proof: Proof, again: Recomputed) -> None:
    """A hundred files, each refused by the name of what was moved."""
    for what, file in islice(altered(proof, again, np.random.default_rng(0)), 100):
        with pytest.raises(ProofError, match=r"does not hold what is computed|does not follow") as refused:
            require_claims(file.proved, again)
        named = what.split()[-1] if what.startswith(("duration", "multiplier")) else what
        assert named in str(refused.value) or what == "unstable"


@pytest.mark.parametrize("bits", [11, 64, 200])
def test_a_proof_holds_in_every_other_precision(bits: int, monkeypatch: pytest.MonkeyPatch) -> None:
    system, start = wheel()
    proof = prove(system, start, SETTINGS)
    monkeypatch.setattr(verification, "OTHER_PRECISION", bits)
    verify(proof, system)


def test_claims_have_room_for_what_another_precision_makes_of_them() -> None:
    """Arb's products of series come out wider by up to 1e-4 in another precision; room is 1/16 of the radius."""
    system, start = wheel()
    proof = prove(system, start, SETTINGS)
    again = recomputed(proof, system)
    (low, high), (under, over) = map(Fraction, proof.proved.state["rate"]), map(Fraction, again.balls.state["rate"])
    assert 1.05 < (high - low) / (over - under) < 1.08


@pytest.mark.slow
def test_a_hundred_files_of_a_gait_and_a_smaller_rate() -> None:
    proof, again = gaits.proof(), gaits.again()
    require_claims(proof.proved, again)
    refused_all(proof, again)
    assert proof.found.rate is not None
    system = verification._prepared(gaits.stabilised(), proof.found.order).system
    with working_precision(proof.found.bits + verification.OTHER_PRECISION):
        along = translations(system, np.array([float(value) for value in again.orbit.centre]))
        reduced = quotient(again.orbit.derivative, along)
        weight = np.array(proof.found.weight)
        assert claimed(reduced, weight, proof.found.rate)[1] == proof.found.rate
        for rate, other in ((0.999 * proof.found.rate, weight), (proof.found.rate, np.eye(len(weight)))):
            with pytest.raises(ProofError, match="of the spectral radius does not follow"):
                claimed(reduced, other, rate)
