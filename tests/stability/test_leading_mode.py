"""The leading multiplier measured in simulation."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import Domain, HybridSystem, Transition
from amble.stability import multipliers
from amble.stability.leading_mode import leading_mode


def decaying(rate: float) -> HybridSystem:
    """A second of standing still, then a share of the deviation: multipliers rate and 0."""
    x = ca.SX.sym("x", 2)
    domain = Domain.from_expressions("stay", x, ca.vertcat(1, 0))
    return HybridSystem(
        [domain], [Transition.from_expressions("stay", "stay", x, x[0] - 1, ca.vertcat(0, rate * x[1]), +1)]
    )


@pytest.mark.parametrize(("rate", "cycles"), [(1.5, 3), (0.9, 3), (-0.3, 3), (0.02, 2), (1e-3, 1)])
def test_a_known_rate_is_measured_while_it_is_to_be_seen(rate: float, cycles: int) -> None:
    system, state = decaying(rate), np.zeros(2)
    found = leading_mode(system, state, multipliers(system, state))
    assert found is not None
    assert found.cycles == cycles
    # linear, so that only the integrator's 1e-12 on what is left, at least 1e-9, remains
    assert found.rate == pytest.approx(abs(rate), rel=1e-3)
    assert found.difference < 1e-3


@pytest.mark.parametrize("rate", [1e-5, 0.0])
def test_what_one_cycle_forgets_is_not_measured(rate: float) -> None:
    system, state = decaying(rate), np.zeros(2)
    assert leading_mode(system, state, multipliers(system, state)) is None
