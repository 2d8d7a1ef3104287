"""What is said of a proof: bounds are rounded outward, neutral directions and the whole cycle are named."""

from __future__ import annotations

from fractions import Fraction

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import Domain, HybridSystem, Transition
from amble.proof import Proof, Settings, prove
from amble.proof.sentences import places, rounded_down, rounded_up, sentences, up_to_a_turn, whole_rate
from amble.simulation import simulate
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


def test_one_orbit_is_one_of_a_cycle() -> None:
    """x -> -(1 + e) x + x^3 has one fixed point, and an orbit of two cycles beside it; both pass the box."""
    x = ca.SX.sym("x", 2)
    stride = Domain.from_expressions("stride", x, ca.vertcat(1, 0))
    after = ca.vertcat(0, -(1 + 2.0**-20) * x[1] + x[1] ** 3)
    step = Transition.from_expressions("stride", "stride", x, x[0] - 1, after, +1)
    system = HybridSystem([stride], [step], (), ("phase", "size"))
    proof = prove(system, np.zeros(2), Settings(order=6, tolerance=1e-12, radius=2.0**-8, basin=0.0))
    there = simulate(system, np.array([0.0, 2.0**-10]), 2, 1e-12).section[-1]
    assert there[1] == pytest.approx(2.0**-10, abs=1e-12)
    assert sentences(proof)[0] == "proved: exactly one periodic orbit of a cycle passes the box"


def test_a_gait_is_described() -> None:
    said = "\n".join(sentences(forged()))
    assert said.startswith("proved: exactly one periodic orbit of half a cycle, mirrored, up to x passes the box")
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
