"""Output weights: exact slopes of the Poincare Jacobian, and orbits that become stable without moving."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.control import DropActuator, PseudoInverse
from amble.errors import InputError, UnknownNameError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop, start_state
from amble.simulation.walking import simulate_gait
from amble.stability.bilinear import bilinear_step, metric
from amble.stability.contraction import section_distances
from amble.stability.descent import smooth_radius
from amble.stability.leading_mode import leading_mode
from amble.stability.monodromy import monodromy
from amble.stability.own_orbit import own_fixed_point
from amble.stability.spectrum import multipliers
from amble.stability.stabilize import NotStabilizedError, Stabilized, _Search, stabilization
from amble.stability.weighted_map import WeightedMap

WEIGHTS = 66
"""Eleven outputs, three base angles, two domains."""


@pytest.fixture(scope="module")
def stabilized(walking_gait: Gait) -> Stabilized:
    return stabilization(walking_gait)


@pytest.fixture(scope="module")
def search(stabilized: Stabilized) -> _Search:
    assert stabilized.gait.feedback is not None
    return _Search.of(stabilized.gait, ("roll", "pitch", "yaw"), [].append)


@pytest.fixture(scope="module")
def at_weights(search: _Search) -> WeightedMap:
    return search.evaluate(np.random.default_rng(3).normal(scale=0.1, size=WEIGHTS))


@pytest.mark.parametrize(("size", "tolerance"), [(0.0, 1e-8), (0.1, 1e-5)])
def test_collocated_jacobian_equals_adaptive_variational_equations(
    search: _Search, size: float, tolerance: float
) -> None:
    """Two code paths: Gauss collocation on the stored orbit, and the adaptive flow of (x, Phi).

    With the weights of the stored orbit both follow it: quadrature and integrator leave 1e-9. The references miss the
    orbit by up to 1e-6 rad/s, which random weights feed back, so that the adaptive flow then follows a motion that
    differs from the stored orbit by about as much; 1e-5 of the largest entry leaves room for it.
    """
    theta = np.random.default_rng(4).normal(scale=size, size=WEIGHTS)
    gait = search.gait_with(theta)
    matrix = monodromy(closed_loop(gait, half=True), search.orbit.start).matrix
    expected = search.orbit.basis.T @ matrix @ search.orbit.basis
    found = search.evaluate(theta).matrix
    assert np.abs(found - expected).max() < tolerance * np.abs(expected).max()


def test_slopes_are_those_of_central_differences(search: _Search, at_weights: WeightedMap) -> None:
    """Along random directions; the step 1e-4 leaves an error of about its square beside slopes of size one."""
    generator = np.random.default_rng(5)
    theta = np.random.default_rng(3).normal(scale=0.1, size=WEIGHTS)
    slopes = at_weights.slopes()
    for _ in range(3):
        direction = generator.normal(size=WEIGHTS)
        ahead, behind = (search.evaluate(theta + sign * 1e-4 * direction).matrix for sign in (1.0, -1.0))
        measured = (ahead - behind) / 2e-4
        expected = np.tensordot(direction, slopes, 1)
        assert np.abs(measured - expected).max() < 1e-5 * np.abs(expected).max()


def test_gradient_contracts_the_slopes(at_weights: WeightedMap) -> None:
    outer = np.random.default_rng(6).normal(size=at_weights.matrix.shape)
    expected = np.einsum("imn,mn->i", at_weights.slopes(), outer)
    assert np.allclose(at_weights.gradient(outer), expected, rtol=1e-9, atol=1e-9 * np.abs(expected).max())


@pytest.mark.parametrize("seed", range(5))
def test_smooth_radius_bounds_the_radius_and_has_its_slope(seed: int) -> None:
    generator = np.random.default_rng(seed)
    matrix, direction = generator.normal(size=(2, 9, 9))
    value, slope = smooth_radius(matrix)
    radius = np.abs(np.linalg.eigvals(matrix)).max()
    assert np.log(radius) <= value <= np.log(radius) + np.log(9.0) / 24.0
    step = 1e-6  # rounding 1e-16 / step and curvature step^2 both stay below the tolerance
    measured = (smooth_radius(matrix + step * direction)[0] - smooth_radius(matrix - step * direction)[0]) / (2 * step)
    assert measured == pytest.approx(float(np.sum(slope * direction)), rel=1e-6, abs=1e-8)


@pytest.mark.parametrize("seed", range(3))
def test_metric_makes_the_matrix_nearly_as_small_as_its_radius(seed: int) -> None:
    matrix = np.random.default_rng(seed).normal(size=(12, 12))
    left = metric(matrix, slack=1.15)
    radius = np.abs(np.linalg.eigvals(matrix)).max()
    norm = np.linalg.norm(np.linalg.inv(left) @ matrix @ left, 2)
    # W - s^2 A W A^T = 1 > 0 means that the scaled matrix contracts in the metric
    assert radius <= norm * (1 + 1e-9)
    assert norm < 1.15 * radius


def test_bilinear_step_keeps_its_promise_on_the_linear_model(at_weights: WeightedMap) -> None:
    step, bound = bilinear_step(at_weights, 0.5)
    assert np.linalg.norm(step) <= 0.5 * (1 + 1e-6)
    moved = at_weights.matrix + np.tensordot(step, at_weights.slopes(), 1)
    assert np.abs(np.linalg.eigvals(moved)).max() <= bound * (1 + 1e-6)


def test_stabilised_below_the_paper(stabilized: Stabilized) -> None:
    """The paper reports 0.6267 of a full cycle; the issue of this project asks for less than 0.5."""
    assert stabilized.initial > 1.0
    assert stabilized.radius < 0.5
    assert stabilized.parameters == WEIGHTS
    assert all(step.drift <= 1e-6 for step in stabilized.steps)


def test_both_laws_have_the_same_radius(stabilized: Stabilized) -> None:
    """Torques that differ by a free direction cause the same motion (docs/theory/allocation.md, eq. 6)."""
    joints = tuple(f"{leg}_hip_pitch" for leg in ("rl", "rr"))
    radii = []
    for law in (PseudoInverse(), DropActuator(joints)):
        gait = replace(stabilized.gait, law=law)
        _, found = own_fixed_point(gait)
        keep = np.r_[2:36]
        matrix = found.monodromy.matrix[np.ix_(keep, keep)]
        radii.append(np.abs(np.linalg.eigvals(matrix)).max() ** 2)
    assert radii[0] == pytest.approx(radii[1], rel=1e-6)
    assert radii[0] == pytest.approx(stabilized.radius, rel=1e-5)


def test_perturbed_start_returns_to_the_orbit(stabilized: Stabilized) -> None:
    """1e-3 on every state; 0.5 a cycle would leave 1e-3 * 0.5^25 = 3e-11, so the integrator's 1e-10 decides."""
    gait = stabilized.gait
    trace = simulate_gait(gait, 25, tolerance=1e-10, perturbation=1e-3, seed=1)
    assert trace.completed
    distance = section_distances(closed_loop(gait), trace.section, start_state(gait))
    assert distance[0] > 1e-4
    assert distance[-1] < 1e-6


def test_simulated_contraction_agrees_with_the_radius(stabilized: Stabilized) -> None:
    """Within 10 %, as asked for; the nonlinearity at 1e-5 leaves about a percent."""
    system = closed_loop(stabilized.gait)
    state = start_state(stabilized.gait)
    mode = leading_mode(system, state, multipliers(system, state))
    assert mode.predicted == pytest.approx(stabilized.radius, rel=1e-4)
    assert mode.difference < 0.1


def test_a_joint_alone_is_not_enough(walking_gait: Gait) -> None:
    """The error says how far it came and which outputs limit it; on the way it is told what is being done."""
    told: list[str] = []
    with pytest.raises(NotStabilizedError, match=r"best spectral radius .* free: fl_knee .* were not: \w+") as caught:
        stabilization(walking_gait, free=("fl_knee",), most_steps=1, doing=told.append)
    best = float(str(caught.value).split("cycle ")[1].split(" ")[0])
    assert 1.0 <= best < 12.0
    assert told[0] == "orbit of the closed loop"
    assert told[1].startswith("evaluation 1 of 60, spectral radius")


def test_matrix_inequalities_reduce_the_radius(walking_gait: Gait) -> None:
    """Two steps from an unstable start do not suffice; what they reach is in the message."""
    with pytest.raises(NotStabilizedError) as caught:
        stabilization(walking_gait, method="bilinear", most_steps=2)
    best = float(str(caught.value).split("cycle ")[1].split(" ")[0])
    assert 1.0 <= best < 10.0


def test_a_target_that_is_not_stable_is_refused(walking_gait: Gait) -> None:
    with pytest.raises(InputError, match="between 0 and 1"):
        stabilization(walking_gait, target=1.5)


def test_unknown_names_are_refused(walking_gait: Gait) -> None:
    with pytest.raises(UnknownNameError, match="known: roll, pitch, yaw"):
        stabilization(walking_gait, free=("heading",))
    with pytest.raises(UnknownNameError, match="bilinear, descent"):
        stabilization(walking_gait, method="magic")  # type: ignore[arg-type]
