"""What is said of a proof: bounds are rounded outward, neutral directions and the whole cycle are named."""

from __future__ import annotations

from fractions import Fraction

import pytest

from amble.proof import Proof
from amble.proof.sentences import places, rounded_down, rounded_up, sentences, up_to_a_turn, whole_rate
from tests.proof.forged import forged


def test_what_is_printed_of_a_bound_is_proved_too() -> None:
    """Lower bounds are rounded down, upper ones up."""
    assert rounded_down(0.1685324, 3) == "0.168"
    assert rounded_down("9.99999046e-7", 3) == "9.99e-7"
    assert rounded_up(0.2500007500000001, 10) == "0.2500007501"
    assert rounded_up(0.625000375, 4) == "0.6251"
    assert rounded_up("226709e-19", 3) == "2.27e-14"
    assert rounded_down(-0.1234, 2) == "-0.13"


@pytest.mark.parametrize("rate", [0.1, 0.45, 0.999999])
def test_the_bound_of_the_whole_cycle_is_no_less_than_the_square(rate: float) -> None:
    assert Fraction(whole_rate(rate, half=True)) >= Fraction(rate) ** 2
    assert whole_rate(rate, half=False) == rate


def test_a_gait_is_described() -> None:
    said = "\n".join(sentences(forged()))
    assert "exponentially stable up to a turn about the vertical" in said
    assert "spectral radius of half a cycle at most 0.5, of the whole cycle 0.2500000001" in said
    assert "bounded in 50 digits at 5 points" in said
    assert "at most 2.27e-14 N and 2e-15 N m more, and feet are within 1.9e-17 m" in said


def test_places_and_turns_follow_from_what_was_found() -> None:
    proof = forged()
    assert places(proof) == 5
    assert up_to_a_turn(proof)
    flat: Proof = forged(weight=[[1.0, 0.0], [0.0, 1.0]])
    assert not up_to_a_turn(flat)
