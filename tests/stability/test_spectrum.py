from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import HybridSystem, Symmetry
from amble.stability import difference_check, fixed_point, multipliers
from amble.stability.spectrum import spectrum
from tests.hybrids import travelling, two_phases

GUESS = np.array([0.0, 0.3, 1.0, -2.0, 0.4])


@pytest.mark.parametrize("mirror", [1, -1])
@pytest.mark.parametrize("turn", [0.0, 0.7])
def test_symmetries_are_neutral_and_taken_out(turn: float, mirror: int) -> None:
    system = travelling(turn, mirror)
    state = fixed_point(system, GUESS).state
    found = multipliers(system, state)
    assert [neutral.name for neutral in found.neutral] == ["x", "y", "heading"]
    assert [neutral.multiplier for neutral in found.neutral] == pytest.approx([1, mirror, mirror], abs=1e-9)
    assert all(neutral.residual < 1e-9 for neutral in found.neutral)
    # what remains: the oscillation alone, which does not see the plane
    lone = multipliers(HybridSystem(*_without_the_plane(turn, mirror)), state[:2])
    assert np.abs(found.multipliers) == pytest.approx(np.abs(lone.multipliers), abs=1e-8)
    assert found.basis.T @ found.basis == pytest.approx(np.eye(2), abs=1e-12)
    assert found.radius < 0.5


def _without_the_plane(turn: float, mirror: int) -> tuple[list, list]:
    whole, x = travelling(turn, mirror), ca.SX.sym("x", 2)
    t, p = ca.SX.sym("t"), ca.SX.sym("p", 0)
    full = ca.vertcat(x, 0, 0, 0)
    domain, leaving = whole.domains[0], whole.transitions[0]

    def cut(function: ca.Function) -> ca.Function:
        value = function(t, full, p)
        names = function.name_in()
        return ca.Function(function.name(), [t, x, p], [value[: min(2, value.numel())]], names, function.name_out())

    return (
        [dataclasses.replace(domain, field=cut(domain.field))],
        [dataclasses.replace(leaving, guard=cut(leaving.guard), reset=cut(leaving.reset))],
    )


def test_a_claimed_symmetry_that_does_not_hold_shows() -> None:
    system = two_phases()
    state = fixed_point(system, np.array([0.0, 1.0, 0.2])).state
    z = ca.SX.sym("z", 3)
    claimed = Symmetry("claimed", ca.Function("claimed", [z], [ca.DM([0, 1, 0])]))
    found = multipliers(HybridSystem(system.domains, system.transitions, [claimed]), state)
    assert found.neutral[0].residual > 1e-2


def test_differences_give_the_same_multipliers() -> None:
    system = travelling(0.7, -1)
    orbit = fixed_point(system, GUESS)
    first = multipliers(system, orbit.state)
    second = spectrum(system, orbit.state, orbit.monodromy.image, difference_check(system, orbit.state).matrix)
    assert second.matrix == pytest.approx(first.matrix, abs=1e-8)
