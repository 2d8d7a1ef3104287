"""Switches have no slopes: what expressions see all the same."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.numerics.unseen import switches, unseen

X, P = ca.SX.sym("x", 3), ca.SX.sym("p")
A, B, C = ca.vertsplit(X)
ALONG = ca.DM([1.0, 1.0, 0.0])

UNSEEN = [
    C + P,
    ca.sin(C),
    ca.if_else(C > 0, C, -C) + ca.sign(C) + ca.floor(C),
    ca.if_else(P < 1, C, 2 * C),
    (A - B) * 3,
    ca.if_else(A < B, 1, 2),  # both move alike
    ca.SX(2.0),
]
SEEN = [
    A,
    ca.sin(B) * C,
    ca.sign(A),
    ca.floor(A + C),
    ca.ceil(2 * B),
    ca.if_else(A < 0, C, 2 * C),
    ca.if_else(A <= B + B, 1, 2),
    ca.if_else(ca.logic_and(C > 0, A > 0), 1, 2),
    ca.if_else(ca.logic_or(C > 0, A == 0), 1, 2),
    ca.if_else(ca.logic_not(A), 1, 2),
    ca.if_else(A, 1, 2),
    ca.fmod(A, 2),
    ca.remainder(A, 2),
    ca.copysign(C, A),
    ca.fabs(A),
    ca.fmin(A, 1),
    ca.fmax(C, B),
    ca.atan2(A, C),
]


@pytest.mark.parametrize("written", UNSEEN, ids=str)
def test_what_does_not_move_is_not_seen(written: ca.SX) -> None:
    assert unseen(written, X, ALONG)
    held(written)


@pytest.mark.parametrize("written", SEEN, ids=str)
def test_what_moves_is_seen_by_slopes_and_by_switches(written: ca.SX) -> None:
    assert not unseen(ca.vertcat(C, written), X, ALONG)


def held(written: ca.SX) -> None:
    """Points moved along have the same value."""
    function, draws = ca.Function("f", [X, P], [written]), np.random.default_rng(0)
    for _ in range(20):
        start, p, far = draws.normal(size=3), draws.normal(), draws.normal()
        moved = start + far * np.asarray(ALONG).reshape(-1)
        assert float(function(moved, p)) == pytest.approx(float(function(start, p)), abs=1e-12)


def test_a_switch_that_moves_alike_on_both_sides_decides_nothing() -> None:
    assert switches(ca.if_else(A < B, 1, 2)).shape == (4, 1)  # the comparison, its contrary, and what each decides
    assert switches(ca.sin(A)).shape == (0, 1)


def test_directions_may_depend_on_the_state() -> None:
    turning = ca.vertcat(-B, A, 0)
    assert unseen(C, X, turning)
    assert not unseen(ca.sign(A), X, turning)
