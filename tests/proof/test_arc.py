"""Sets through a domain along steps that somebody else chose: no crossing is passed, none is counted that is none."""

from __future__ import annotations

import casadi as ca
import pytest
from flint import arb

from amble.hybrid import Domain, Transition
from amble.proof import ProofError
from amble.proof.arc import Arc, follow
from amble.proof.arithmetic import working_precision
from amble.proof.leg import Leg
from amble.proof.moving_set import MovingSet

X = ca.SX.sym("x", 1)
ROUNDS = ca.sin(6 * X) - 0.5
"""Rises through zero at 0.0873 and 1.1345, falls at 0.4363."""


def along(guard: ca.SX, lengths: list[float], start: float = 0.0, radius: float = 1e-10, dead_time: float = 0.0) -> Arc:
    """A clock as the state, followed along steps."""
    domain = Domain.from_expressions("d", X, ca.SX(1))
    leave = Transition.from_expressions("d", "d", X, guard, 0 * X, +1, dead_time=dead_time)
    with working_precision(128):
        return follow(
            Leg.of(domain, leave), MovingSet.about([arb(start)], [arb(radius)]), 12, 1e-20, list(map(arb, lengths))
        )


FIRST, SECOND = 0.08726646259971647, 1.1344640137963142


def test_the_first_crossing_is_found() -> None:
    assert float(along(ROUNDS, [0.05, FIRST - 0.05]).duration) == pytest.approx(FIRST, abs=1e-9)


@pytest.mark.parametrize(
    "lengths",
    [
        [SECOND],  # over three crossings
        [1.0, SECOND - 1.0],  # over the first one and where it falls
        [0.05, 0.03, SECOND - 0.08],
        [0.05, 0.1, SECOND - 0.15],  # the first crossing within a short step
    ],
)
def test_a_later_crossing_is_not_the_exit(lengths: list[float]) -> None:
    with pytest.raises(ProofError, match=r"crossed more than once|steps end before|not crossed|enclosed|no enclosure"):
        along(ROUNDS, lengths)


def test_within_the_dead_time_a_crossing_does_not_count() -> None:
    found = along(ROUNDS, [0.1, 0.2, 0.2, 0.3, 0.2, SECOND - 1.0], dead_time=0.25)
    assert float(found.duration) == pytest.approx(SECOND, abs=1e-9)
    with pytest.raises(ProofError):
        along(ROUNDS, [0.05, FIRST - 0.05], dead_time=0.25)


@pytest.mark.parametrize("start", [0.0, 1e-11, 0.25])
def test_a_set_on_the_guard_or_behind_it_does_not_cross_at_once(start: float) -> None:
    """Some of its points start past zero, and have to come back before they can leave."""
    for lengths in ([1e-3], [0.01, 0.1], [1e-11, 1e-3]):
        with pytest.raises(ProofError):
            along(X, lengths, start)


def test_a_guard_that_is_touched_is_not_crossed() -> None:
    for lengths in ([1.0], [0.9, 0.1], [0.9, 0.2]):
        with pytest.raises(ProofError):
            along(-((X - 1) ** 2), lengths)


def test_a_set_of_which_some_points_do_not_reach_the_guard_is_refused() -> None:
    """A top of 1e-9 above the guard, and a set of 1e-4."""
    with pytest.raises(ProofError):
        along(1e-9 - (X - 1) ** 2, [0.9, 0.1 - 3e-5], radius=1e-4)
