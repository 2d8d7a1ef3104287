"""Points that glide through a cycle, and the sentences where there is no motion or no single fixed point."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Symmetry, Transition
from amble.proof import ProofError, Settings, prove, verify

SETTINGS = Settings(order=14, tolerance=1e-22, radius=1e-17, basin=1e-4)
T, X, Y = ca.SX.sym("t"), ca.SX.sym("x"), ca.SX.sym("x", 2)


def timed(state: ca.SX, rate: list[ca.SX], after: list[ca.SX], *symmetries: Symmetry) -> HybridSystem:
    """One domain that is left after a second."""
    domain = Domain.from_expressions("d", state, ca.vertcat(*rate), clock=T)
    leave = Transition.from_expressions("d", "d", state, T - 1, ca.vertcat(*after), +1, clock=T)
    return HybridSystem([domain], [leave], symmetries=symmetries)


@pytest.mark.parametrize("gravity", [9.81, 1.0])
def test_a_flight_is_followed_to_its_landing(gravity: float) -> None:
    """A ball that is struck up at every landing: its motion is a polynomial, and it starts on the guard."""
    domain = Domain.from_expressions("flight", Y, ca.vertcat(Y[1], ca.SX(-gravity)))
    landing = Transition.from_expressions("flight", "flight", Y, Y[0], ca.vertcat(0, 0.4 - 0.8 * Y[1]), -1)
    system = HybridSystem([domain], [landing])
    proof = prove(system, np.array([0.0, 1.99]), SETTINGS)
    (low, high) = map(float, proof.proved.state["x1"])
    assert low == pytest.approx(2.0, abs=1e-15) == high
    assert proof.found.rate == pytest.approx(0.8, abs=1e-3)
    verify(proof, system)


def test_a_size_that_does_not_change_its_sign() -> None:
    """The slope of a size is a sign."""
    system = timed(X, [-ca.fabs(X)], [X + 1])
    proof = prove(system, np.array([1.5]), SETTINGS)
    assert proof.found.rate == pytest.approx(np.exp(-1), abs=1e-4)
    verify(proof, system)


@pytest.mark.parametrize(
    ("system", "start", "reason"),
    [
        (timed(Y, [1 - Y[0], ca.SX(0)], [Y[0] / 2, Y[1]]), [0.4, 1.0], "come in families"),
        (timed(Y, [1 - Y[0], ca.SX(1)], [Y[0] / 2, Y[1] - 1]), [0.4, 1.0], "come in families"),
        (timed(Y, [ca.sqrt(T), -Y[1]], [ca.SX(0), Y[1] + 1]), [0.0, 1.58], "no Taylor series in domain 'd' at clock 0"),
        (timed(X, [ca.fmax(0, T - 0.5) - X], [X + 1]), [1.6], r"switch .* in domain 'd' at clock 0"),
    ],
)
def test_what_has_no_proof_is_named_with_its_place(system: HybridSystem, start: list[float], reason: str) -> None:
    with pytest.raises(ProofError, match=reason):
        prove(system, np.array(start), SETTINGS)


def test_what_is_no_question_of_stability_is_refused() -> None:
    everything = Symmetry("x", ca.Function("g", [X], [ca.SX(1)]))
    with pytest.raises(InputError, match="translate every state"):
        prove(timed(X, [ca.SX(1)], [X], everything), np.array([0.4]), SETTINGS)
    with pytest.raises(InputError, match="of 1 states"):
        prove(timed(X, [-X], [X + 1]), np.array([1.0, 2.0]), SETTINGS)
    with pytest.raises(InputError, match="holds sinh"):
        prove(timed(X, [-ca.sinh(X)], [X + 1]), np.array([1.3]), SETTINGS)


def test_a_return_map_on_the_unit_circle_is_neither_stable_nor_unstable() -> None:
    """W near rate 1 is ill-conditioned: no warning of it comes through."""
    turning = timed(Y, [Y[1], -Y[0]], [Y[0], Y[1]])
    proof = prove(turning, np.zeros(2), SETTINGS)
    assert not proof.stable
    assert proof.proved.unstable is None
