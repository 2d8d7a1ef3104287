from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
import pytest

from amble.hybrid import HybridSystem, Symmetry
from amble.stability import difference_check, fixed_point, multipliers
from amble.stability.spectrum import largest_radius, pseudospectral_radius, radius, spectrum
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


@pytest.mark.parametrize("size", [1e-10, 1e-6, 1e-2, 1.0])
def test_an_eigenvalue_of_a_normal_matrix_moves_by_the_perturbation(size: float) -> None:
    c, s = np.cos(0.7), np.sin(0.7)
    matrix = 0.8 * np.array([[c, -s, 0], [s, c, 0], [0, 0, 0.3]])
    assert pseudospectral_radius(matrix, size) == pytest.approx(0.8 + size, rel=1e-12, abs=3e-3 * size)


@pytest.mark.parametrize("n", [2, 3])
def test_an_eigenvalue_of_a_jordan_block_moves_by_a_root_of_the_perturbation(n: int) -> None:
    size = 1e-9
    measured = pseudospectral_radius(np.eye(n, k=1), size)
    assert measured == pytest.approx(size ** (1 / n), rel=1e-2)  # the leading term for small perturbations


def test_no_perturbation_exceeds_it() -> None:
    rng = np.random.default_rng(3)
    matrix = rng.normal(size=(6, 6)) / 3
    estimate = pseudospectral_radius(matrix, 1e-2)
    assert estimate > radius(matrix)
    reached = 0.0
    for _ in range(2000):
        perturbation = rng.normal(size=(6, 1)) @ rng.normal(size=(1, 6))
        reached = max(reached, radius(matrix + 1e-2 * perturbation / np.linalg.norm(perturbation, 2)))
    assert radius(matrix) < reached <= estimate


@pytest.mark.parametrize("size", [1e-8, 1e-3, 0.3])
def test_it_is_the_largest_circle_that_meets_the_level(size: float) -> None:
    """Bisection with every angle looked at every time, on matrices far from normal."""
    rng = np.random.default_rng(5)
    for n in (4, 9):
        matrix = np.triu(rng.normal(size=(n, n)), k=1) + np.diag(rng.uniform(-1.0, 1.0, n))
        angles = np.concatenate([np.linspace(0.0, np.pi, 181), np.abs(np.angle(np.linalg.eigvals(matrix)))])
        low, high = radius(matrix), float(np.linalg.norm(matrix, 2)) + size
        for _ in range(60):
            middle = 0.5 * (low + high)
            circle = middle * np.exp(1j * angles)[:, None, None]
            meets = np.linalg.svd(circle * np.eye(n) - matrix, compute_uv=False)[:, -1].min() <= size
            low, high = (middle, high) if meets else (low, middle)
        found = pseudospectral_radius(matrix, size)
        assert -1e-12 <= found - high <= 1e-3 * (found - radius(matrix)) + 1e-12


def test_without_a_perturbation_nothing_moves() -> None:
    assert pseudospectral_radius(np.diag([0.5, -0.7]), 0.0) == pytest.approx(0.7)


@pytest.mark.parametrize("scale", [1.0, 1e4])
def test_the_estimate_covers_the_doubt_and_is_sharper_in_suitable_coordinates(scale: float) -> None:
    rng = np.random.default_rng(8)
    stretch = np.diag([1.0, scale, 1.0, scale])
    matrix = stretch @ (0.4 * rng.normal(size=(4, 4))) @ np.linalg.inv(stretch)
    doubt = stretch @ (1e-6 * rng.normal(size=(4, 4))) @ np.linalg.inv(stretch)
    estimate = largest_radius(matrix, [doubt])
    for sign in (1, -1):
        assert radius(matrix + sign * doubt) <= estimate
    assert estimate <= pseudospectral_radius(matrix, float(np.linalg.norm(doubt, 2)))
    assert estimate - radius(matrix) < 1e-4


def test_a_map_that_forgets_everything_has_an_estimate() -> None:
    assert largest_radius(np.zeros((3, 3)), [1e-6 * np.eye(3)]) == pytest.approx(1e-6, rel=1e-2)
    assert largest_radius(np.eye(3, k=1), [1e-9 * np.eye(3)]) <= 1.01e-3
