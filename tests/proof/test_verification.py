"""Proofs are verified from their files; files with one number moved inward are refused, by what was moved."""

from __future__ import annotations

from dataclasses import replace
from fractions import Fraction
from itertools import islice

import numpy as np
import pytest
from examples import rimless_wheel, simplest_walker
from flint import arb, arb_mat

from amble.errors import InputError
from amble.hybrid import HybridSystem
from amble.proof import Proof, ProofError, Settings, prove, verification, verify
from amble.proof.arithmetic import working_precision
from amble.proof.quotient import claimed, complement, gershgorin, lyapunov, quotient, translations
from amble.proof.verification import Recomputed, recomputed, require_claims
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.types import Matrix, Vector
from tests.proof import gaits
from tests.proof.altered import altered, searched

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


@pytest.mark.parametrize("walker", [wheel, pytest.param(simplest_walker.long_step, marks=pytest.mark.slow)])
def test_what_was_searched_and_is_another_is_refused(walker: type[wheel]) -> None:  # type: ignore[valid-type]
    """Rate, W, box, steps and basin, by the whole of verification."""
    system, start = walker()
    proof = prove(system, start, replace(SETTINGS, basin=1e-3))
    again, refused = recomputed(proof, system), []
    assert again.basin is not None
    for what, file in searched(proof, again, np.random.default_rng(0)):
        with pytest.raises((ProofError, InputError)):
            verify(file, system)
        refused.append(what)
    assert {"the rate", "W", "a radius", "the centre", "the last step", "the basin's rate"} <= set(refused)


def test_the_weight_of_another_walker_is_refused() -> None:
    system, start = wheel()
    other = rimless_wheel.rimless_wheel(8, 0.15), np.array([0.15 - np.pi / 8, rimless_wheel.known_rate(8, 0.15)])
    proof, beside = prove(system, start, SETTINGS), prove(*other, SETTINGS)
    tree = proof.model_dump(mode="json")
    tree["found"]["weight"] = beside.model_dump(mode="json")["found"]["weight"]
    with pytest.raises(ProofError, match="of the spectral radius does not follow"):
        verify(Proof.model_validate(tree, strict=False), system)


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


def test_discs_in_another_precision_lie_within() -> None:
    """Of matrices with complex pairs, eigenvectors come out in another length and phase; room is 1/16 of the radius."""
    draws = np.random.default_rng(3)
    for _ in range(20):
        entries = draws.normal(size=16)
        discs = []
        for bits, radius in ((128, 17 / 16 * 1e-15), (181, 1e-15)):
            with working_precision(bits):
                balls = [arb(float(entry), radius) for entry in entries]
                discs.append([ball for ball, alone in gershgorin(arb_mat(4, 4, balls)) if alone])
        assert len(discs[0]) == len(discs[1])
        for ball in discs[1]:
            assert sum(other.contains(ball) for other in discs[0]) == 1


def test_a_proof_by_default_settings_is_verified() -> None:
    system, start = simplest_walker.long_step()
    verify(prove(system, start, Settings(basin=0.0)), system)


@pytest.mark.slow
def test_a_hundred_files_of_a_gait_and_a_smaller_rate() -> None:
    proof, again = gaits.proof(), gaits.again()
    require_claims(proof.proved, again)
    verification.require_same(proof, gaits.stabilised())
    refused_all(proof, again)
    assert proof.found.rate is not None
    draws = np.random.default_rng(2)
    system = verification._prepared(gaits.stabilised(), proof.found.order).system
    with working_precision(proof.found.bits + verification.OTHER_PRECISION):
        along = translations(system, np.array([float(value) for value in again.orbit.centre]))
        reduced = quotient(again.orbit.derivative, along)
        weight = np.array(proof.found.weight)
        assert claimed(reduced, weight, proof.found.rate)[1] == proof.found.rate
        middle = np.array([[float(entry.mid()) for entry in row] for row in reduced.tolist()])
        radius = float(np.abs(np.linalg.eigvals(middle)).max())
        files = dict(searched(proof, again, draws, radius))
        lower = files["the rate"].found.rate
        assert lower is not None
        for rate, other in (
            (lower, weight),
            (0.999 * proof.found.rate, weight),
            (proof.found.rate, np.array(files["W"].found.weight)),
            (proof.found.rate, weight_of_another_gait(proof.found.rate)),
            (proof.found.rate, np.eye(len(weight))),
        ):
            with pytest.raises(ProofError, match="of the spectral radius does not follow"):
                claimed(reduced, other, rate)


def weight_of_another_gait(rate: float) -> Matrix:
    """The same orbit under half as large gains again: another loop, with a derivative of its own."""
    gait = gaits.stabilised()
    position, velocity = gait.gains
    system, found = closed_loop_fixed_point(replace(gait, gains=(1.5 * position, 1.2 * velocity)))
    span, full = complement(translations(system, found.state))
    block = (np.linalg.inv(full) @ found.monodromy.matrix @ span)[full.shape[1] - span.shape[1] :]
    radius = float(np.abs(np.linalg.eigvals(block)).max())
    return lyapunov(block, max(rate, radius + 1e-6))
