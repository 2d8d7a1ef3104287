"""Sets through guards: where they hardly move, are exact, or stand still until a rate sets in, in any precision."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import Domain, HybridSystem, Transition
from amble.proof import Settings, prove, verify

T, X = ca.SX.sym("t"), ca.SX.sym("x", 2)
PHASE, SIZE = ca.vertsplit(X)
RADIUS = {64: 1e-12, 128: 1e-19, 300: 1e-60}


def clocked(rate: ca.SX | float, after: ca.SX | float) -> HybridSystem:
    """A phase that grows to 1, and a size."""
    domain = Domain.from_expressions("stride", X, ca.vertcat(1, rate), clock=T)
    step = Transition.from_expressions("stride", "stride", X, PHASE - 1, ca.vertcat(0, after), +1)
    return HybridSystem([domain], [step], (), ("phase", "size"))


@pytest.mark.parametrize(
    ("rate", "after", "multiplier", "bits"),
    [
        (0, 0.5 * SIZE + 1, 0.5, 64),
        (0, 0.5 * SIZE + 1, 0.5, 300),  # stands still: tube and hull are one ball
        (SIZE, 0.125 * SIZE, 0.125 * np.e, 128),
        (-3 * SIZE, SIZE + 1, np.exp(-3.0), 128),  # contracts
        (1e3 * (T - 1), 0.5 * SIZE, 0.5, 128),  # no rate where the centre crosses, a steep one beside it
        (0, 3.0, 0.0, 128),  # exact
    ],
    ids=["still", "still in 300 bits", "growing", "contracting", "turning", "exact"],
)
def test_a_set_that_hardly_moves_at_the_guard(rate: ca.SX, after: ca.SX, multiplier: float, bits: int) -> None:
    system = clocked(rate, after)
    settings = Settings(bits=bits, order=12, tolerance=1e-15 if bits == 64 else 1e-25, radius=RADIUS[bits], basin=0.0)
    proof = prove(system, np.zeros(2), settings)
    assert proof.stable
    assert proof.found.rate == pytest.approx(multiplier, abs=1e-5)
    verify(proof, system)


def test_a_stretch_in_which_nothing_moves() -> None:
    """A dwell on the clock alone between two strides; its start is exact where the reset before it is constant."""
    stride = Domain.from_expressions("stride", X, ca.vertcat(1, -SIZE))
    dwell = Domain.from_expressions("dwell", X, ca.SX(2, 1), clock=T)
    for after in (ca.vertcat(0, SIZE + 1), ca.vertcat(0, 1)):
        land = Transition.from_expressions("stride", "dwell", X, PHASE - 1, after, +1)
        leave = Transition.from_expressions("dwell", "stride", X, T - 0.25, X, +1, clock=T)
        system = HybridSystem([stride, dwell], [land, leave], (), ("phase", "size"))
        proof = prove(system, np.array([0.0, 1.0]), Settings(order=12, basin=1e-3))
        assert proof.stable
        assert proof.proved.basin_rate is not None
        verify(proof, system)
