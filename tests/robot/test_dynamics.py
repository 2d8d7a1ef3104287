"""Dynamics against Pinocchio at 1,000 seeded random states, and against the laws of mechanics."""

from __future__ import annotations

import casadi as ca
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from amble.robot import Robot, dynamics
from amble.types import Matrix
from tests.oracle import Oracle, oracle
from tests.robot.sampling import relative_error, sampled, theirs
from tests.robots import EVERY_BASE, FOREIGN, random_states, robot

STATES = 1000

# Both sides round at 1e-16 per operation over chains of about a hundred operations; 1e-10 is the promise, and what is
# measured is about 1e-15.
TOLERANCE = 1e-10


@pytest.fixture(params=[*EVERY_BASE, *FOREIGN])
def name(request: pytest.FixtureRequest) -> str:
    return str(request.param)


@pytest.fixture
def model(name: str) -> Robot:
    return robot(name)


@pytest.fixture
def expected(name: str) -> Oracle:
    return oracle(name)


def test_mass_matrix_equals_pinocchio(model: Robot, expected: Oracle) -> None:
    q, _ = random_states(model, STATES)
    ours = np.asarray(sampled(model, lambda q: dynamics.mass_matrix(model, q), q))
    assert relative_error(ours, theirs(expected.mass_matrix, q)) < TOLERANCE


def test_bias_equals_pinocchio(model: Robot, expected: Oracle) -> None:
    q, v = random_states(model, STATES, seed=1)
    ours = sampled(model, lambda q, v: dynamics.bias(model, q, v), q, v)
    assert relative_error(ours, theirs(expected.bias, q, v)) < TOLERANCE


def test_inverse_dynamics_equals_pinocchio(model: Robot, expected: Oracle) -> None:
    q, v = random_states(model, STATES, seed=2)
    a = 10.0 * random_states(model, STATES, seed=3)[1]
    ours = sampled(model, lambda q, v, a: dynamics.inverse_dynamics(model, q, v, a), q, v, a)
    assert relative_error(ours, theirs(expected.inverse_dynamics, q, v, a)) < TOLERANCE


def test_energy_equals_pinocchio(model: Robot, expected: Oracle) -> None:
    q, v = random_states(model, STATES, seed=4)
    kinetic = sampled(model, lambda q, v: dynamics.kinetic_energy(model, q, v), q, v)
    potential = sampled(model, lambda q: dynamics.potential_energy(model, q), q)
    assert relative_error(kinetic, theirs(expected.kinetic_energy, q, v)) < TOLERANCE
    # the potential passes through zero, so its error is relative to a height of one metre
    deviation = np.abs(potential - theirs(expected.potential_energy, q)).max()
    assert deviation < TOLERANCE * model.mass * model.gravity


def test_momentum_equals_pinocchio(model: Robot, expected: Oracle) -> None:
    q, v = random_states(model, STATES, seed=5)
    ours = sampled(model, lambda q, v: ca.vertcat(*dynamics.momentum(model, q, v)), q, v)
    assert relative_error(ours, theirs(expected.momentum, q, v)) < TOLERANCE


def test_kinetic_energy_is_the_quadratic_form_of_the_mass_matrix(model: Robot) -> None:
    q, v = random_states(model, 50, seed=6)
    quadratic = sampled(model, lambda q, v: 0.5 * ca.bilin(dynamics.mass_matrix(model, q), v, v), q, v)
    by_links = sampled(model, lambda q, v: dynamics.kinetic_energy(model, q, v), q, v)
    np.testing.assert_allclose(quadratic, by_links, rtol=1e-12)  # about a thousand roundings


def test_bias_follows_from_the_lagrangian(model: Robot) -> None:
    """h = dD/dt v - dT/dq + dV/dq, with T and V summed link by link: a second code path by derivatives."""
    q, v = random_states(model, 20, seed=7)

    def lagrangian(q: ca.SX, v: ca.SX) -> ca.SX:
        kinetic, potential = dynamics.kinetic_energy(model, q, v), dynamics.potential_energy(model, q)
        conjugate = ca.gradient(kinetic, v)
        return ca.jtimes(conjugate, q, v) - ca.gradient(kinetic, q) + ca.gradient(potential, q)

    ours = sampled(model, lambda q, v: dynamics.bias(model, q, v), q, v)
    assert relative_error(ours, sampled(model, lagrangian, q, v)) < 1e-11  # derivatives lengthen the rounding chains


def test_mass_matrix_is_positive_definite_and_sparse(model: Robot) -> None:
    q, _ = random_states(model, 50, seed=8)
    for pose in q:
        matrix = np.asarray(dynamics.mass_matrix(model, pose))
        np.testing.assert_array_equal(matrix, matrix.T)
        assert np.linalg.eigvalsh(matrix)[0] > 0.0
    pattern = np.asarray(ca.DM(dynamics.mass_matrix(model, ca.SX.sym("q", model.size)).sparsity(), 1.0))
    legs = [[model.coordinate_index(joint) for joint in joints] for joints in model.legs.values()]
    for i, leg in enumerate(legs):
        for other in legs[i + 1 :]:
            assert not pattern[np.ix_(leg, other)].any()


def flight(model: Robot, seconds: float) -> tuple[Matrix, Matrix]:
    """Free flight without torque from a spinning start, by an integrator that knows no mechanics."""
    q, v = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size)
    a = ca.solve(dynamics.mass_matrix(model, q), -dynamics.bias(model, q, v))
    field = ca.Function("flight", [ca.vertcat(q, v)], [ca.densify(ca.vertcat(v, a))])
    generator = np.random.default_rng(9)
    start = np.concatenate([generator.uniform(-0.5, 0.5, model.size), generator.normal(0.0, 1.0, model.size)])
    result = solve_ivp(
        lambda _, x: np.asarray(field(x)).ravel(), (0.0, seconds), start, method="DOP853", rtol=1e-11, atol=1e-12
    )
    assert result.success
    return result.t, result.y.T


def test_flight_conserves_energy_and_momentum(model: Robot) -> None:
    times, states = flight(model, 0.4)
    q, v = states[:, : model.size], states[:, model.size :]
    energy = sampled(
        model, lambda q, v: dynamics.kinetic_energy(model, q, v) + dynamics.potential_energy(model, q), q, v
    )
    kinetic = sampled(model, lambda q, v: dynamics.kinetic_energy(model, q, v), q, v)
    assert np.ptp(energy) < 1e-8 * kinetic.max()  # 1e-11 per step over about a hundred steps
    assert np.ptp(kinetic) > 1e-3 * kinetic.max()  # the law is not met by standing still

    momenta = sampled(model, lambda q, v: ca.vertcat(*dynamics.momentum(model, q, v)), q, v)
    linear, size = momenta[:, :3], np.abs(momenta).max()
    weight = model.mass * model.gravity
    np.testing.assert_allclose(linear[:, :2] - linear[0, :2], 0.0, atol=1e-8 * size)
    np.testing.assert_allclose(linear[:, 2] - linear[0, 2], -weight * times, atol=1e-8 * (size + weight))
    center = oracle(model.name)
    spin = np.array(
        [row[3:] - np.cross(center.center_of_mass(pose), row[:3]) for row, pose in zip(momenta, q, strict=True)]
    )
    np.testing.assert_allclose(spin - spin[0], 0.0, atol=1e-8 * size)


@pytest.mark.parametrize("kind", [ca.SX, ca.MX])
def test_symbolic_types_come_back(kind: type) -> None:
    model = robot("astro")
    q, v = kind.sym("q", model.size), kind.sym("v", model.size)
    for value in (dynamics.mass_matrix(model, q), dynamics.bias(model, q, v), *dynamics.momentum(model, q, v)):
        assert isinstance(value, kind)


def test_operations_stay_few() -> None:
    """A regression bound: 1,951 instructions for D and h of ASTRo when this was written."""
    model = robot("astro")
    q, v = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size)
    terms = ca.cse([dynamics.mass_matrix(model, q), dynamics.bias(model, q, v)])
    assert ca.Function("terms", [q, v], terms).n_instructions() < 2000
