from __future__ import annotations

import dataclasses

import numpy as np
import pytest

from amble.errors import InputError
from amble.hybrid import HybridSystem
from amble.stability.group import act, closest_shift, generators
from tests.hybrids import travelling, two_phases

STATE = np.array([0.1, 0.2, 1.0, -2.0, 0.4])


def test_the_action_is_the_rigid_motion() -> None:
    turn = act(travelling(0.0, 1), np.array([0.0, 0.0, 1.1]), STATE)
    c, s = np.cos(1.1), np.sin(1.1)
    assert turn.image == pytest.approx([0.1, 0.2, c + 2 * s, s - 2 * c, 1.5], abs=1e-12)
    assert turn.matrix[2:4, 2:4] == pytest.approx(np.array([[c, -s], [s, c]]), abs=1e-12)
    shift = act(travelling(0.0, 1), np.array([3.0, -4.0, 0.0]), STATE)
    assert shift.image == pytest.approx(STATE + np.array([0, 0, 3, -4, 0]), abs=1e-12)


@pytest.mark.parametrize("amounts", [(0.0, 0.0, 0.0), (1.0, 2.0, 0.3), (-0.5, 0.1, -1.6)])
def test_inverse_and_identity(amounts: tuple[float, ...]) -> None:
    system = travelling(0.0, 1)
    there = act(system, np.array(amounts), STATE)
    back = act(system, -np.array(amounts), there.image)
    assert back.image == pytest.approx(STATE, abs=1e-11)
    assert back.matrix @ there.matrix == pytest.approx(np.eye(5), abs=1e-11)


@pytest.mark.parametrize("amounts", [(1.0, 2.0, 0.3), (-0.5, 0.1, -1.6)])
def test_the_closest_element_is_the_one_that_moved_the_state(amounts: tuple[float, ...]) -> None:
    system = travelling(0.0, 1)
    target = act(system, np.array(amounts), STATE).image
    assert closest_shift(system, STATE, target).amounts == pytest.approx(amounts, abs=1e-10)


def test_slopes_are_derivatives_of_the_action() -> None:
    system, amounts, h = travelling(0.0, 1), np.array([0.3, -0.2, 0.9]), 1e-5
    slopes = act(system, amounts, STATE).slopes
    for i, unit in enumerate(np.eye(3)):
        change = act(system, amounts + h * unit, STATE).image - act(system, amounts - h * unit, STATE).image
        assert slopes[:, i] == pytest.approx(change / (2 * h), abs=1e-9)  # h^2 and roundoff / h


def test_without_symmetries_nothing_moves() -> None:
    system = two_phases()
    shift = closest_shift(system, np.ones(3), np.zeros(3))
    assert np.array_equal(shift.image, np.ones(3))
    assert generators(system, np.ones(3)).shape == (3, 0)


def test_dependent_symmetries_are_refused() -> None:
    system = travelling(0.0, 1)
    twice = (system.symmetries[0], dataclasses.replace(system.symmetries[0], name="again"))
    other = HybridSystem(system.domains, system.transitions, twice, system.state_names)
    with pytest.raises(InputError, match="x, again are dependent"):
        generators(other, STATE)


def test_a_generator_of_another_size_is_refused() -> None:
    """Any of three exceptions would do, at whichever later step casadi stumbled."""
    system, foreign = two_phases(), travelling(0.0, 1).symmetries
    size = foreign[0].generator.numel_in(0)
    assert size != system.state_size
    with pytest.raises(InputError, match=f"symmetry 'x' maps {size} states to {size} rates, not 3 of each"):
        HybridSystem(system.domains, system.transitions, foreign)
