"""Laws of a closed loop whose phase is a function of the configuration."""

from __future__ import annotations

from functools import lru_cache

import casadi as ca
import numpy as np
import pytest
from examples.extending.phase_configuration import ConfigurationPhase

from amble.control import TimePhase
from amble.control.linearisation import linearise
from amble.control.phase import DomainPhase
from amble.control.sensitivity import sensitivity
from amble.control.virtual_constraints import VirtualConstraints, _basis, pack
from amble.hybrid import Contacts
from amble.numerics.bezier import bernstein_derivatives, evaluate
from amble.types import Matrix, Vector
from amble.verification.output_dynamics import OutputDynamics
from amble.verification.stance_model import terms
from tests.control.loops import LAWS, ORDER, Sample, samples, solved_stances, weights
from tests.robots import robot

STANCE = solved_stances()[0]
PHASE = ConfigurationPhase({"D1": {"y": -1.0, "roll": 0.5}})
H = weights(STANCE)
NAMES = ("acceleration", "torques", "pivot", "slope", "error", "response", "automatic", "clock", "law")


@lru_cache(maxsize=2)
def loop(on_time: bool = False) -> ca.Function:
    """(q, v, t, p) -> the closed loop, its derivatives, and y'' + K_d y' + K_p y along its own flow."""
    model, phase = robot("astro"), TimePhase() if on_time else PHASE
    q, v, t = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size), ca.SX.sym("t")
    constraints = VirtualConstraints.symbols(11, model.size - 3, ORDER, phase)
    rates = constraints.phase_rates(model, STANCE, t, q, v)
    closed = linearise(Contacts(model, STANCE.feet), LAWS["pinv"], q, v, rates, constraints)
    slopes = sensitivity(Contacts(model, STANCE.feet), closed, q, v, constraints)
    x, a = ca.vertcat(q, v), closed.acceleration
    # the definition of the outputs, differentiated along the flow
    basis, _, _ = bernstein_derivatives(ORDER, rates.value)
    y = ca.DM(H) @ (q[3:] - constraints.references @ ca.vertcat(*basis))
    dy = ca.jtimes(y, ca.vertcat(x, t), ca.vertcat(v, a, 1.0))
    ddy = ca.jtimes(dy, ca.vertcat(x, t), ca.vertcat(v, a, 1.0))
    law = ddy + constraints.gains[1] * dy + constraints.gains[0] * y
    parts = [a, closed.torques, closed.pivot, slopes.acceleration, slopes.error, slopes.response]
    parts += [ca.jacobian(a, x), ca.jacobian(a, t), law]
    return ca.Function(
        "loop", [q, v, t, constraints.packed()], [ca.densify(part) for part in parts], ["q", "v", "t", "p"], list(NAMES)
    )


def numbers(sample: Sample) -> Vector:
    """Where the phase begins and ends, so that a state lies at 0.4 of a range of 0.1."""
    domain = DomainPhase(phase=PHASE, robot=robot("astro"), stance=STANCE)
    theta = domain.measured(sample.q, sample.q)[0]
    return np.array([theta - 0.04, theta + 0.06])


def packed(sample: Sample) -> Vector:
    return pack(sample.duration, sample.gains, sample.references, H, numbers(sample))


def evaluated(sample: Sample, p: Vector, on_time: bool = False) -> dict[str, Matrix]:
    found = loop(on_time)(sample.q, sample.v, sample.t, p)
    return dict(zip(NAMES, (np.asarray(part) for part in found), strict=True))


def test_the_output_dynamics_hold_along_the_flow() -> None:
    """From random states, for the first steps of the closed loop's own motion."""
    for sample, _ in samples(5, seed=21):
        p, x, step, size = packed(sample), np.concatenate([sample.q, sample.v]), 1e-4, sample.q.size
        for _ in range(5):
            moved = Sample(x[:size], x[size:], 0.0, sample.duration, sample.gains, sample.references)
            found = evaluated(moved, p)
            scale = np.abs(found["acceleration"]).max() * sample.gains[0]
            # accelerations of 1e4 by equations with a condition of up to 1e4
            np.testing.assert_allclose(found["law"], 0.0, atol=1e-9 * scale)
            x = x + step * np.concatenate([moved.v, found["acceleration"].ravel()])


def test_nothing_depends_on_the_clock() -> None:
    for sample, _ in samples(3, seed=22):
        found = evaluated(sample, packed(sample))
        assert not np.any(found["clock"])
        later = Sample(sample.q, sample.v, sample.t + 0.3, 2.0 * sample.duration, sample.gains, sample.references)
        p = packed(later)
        np.testing.assert_array_equal(evaluated(later, p)["acceleration"], found["acceleration"])
    assert np.any(evaluated(sample, pack(0.2, sample.gains, sample.references, H), on_time=True)["clock"])


def test_derivatives_equal_automatic_differentiation() -> None:
    for sample, _ in samples(10, seed=23):
        found = evaluated(sample, packed(sample))
        # two orders of the same solves, with conditions of up to 1e4
        np.testing.assert_allclose(found["slope"], found["automatic"], atol=1e-9 * np.abs(found["automatic"]).max())


def test_weighted_errors_have_no_slope() -> None:
    for sample, _ in samples(5, seed=24):
        error = evaluated(sample, packed(sample))["error"]
        np.testing.assert_allclose(H @ error, 0.0, atol=1e-8 * np.abs(error).max())


def test_a_change_of_weights_acts_through_the_error() -> None:
    """Where y = y' = 0 and y_a'' = w for all of y_a: d(acceleration slope) = -R H^+ dH E."""
    sample, _ = on_orbit(samples(1, seed=25)[0][0])
    step = 1e-6
    found = evaluated(sample, packed(sample))
    change = np.random.default_rng(26).normal(size=H.shape)
    moved = [
        evaluated(
            sample, pack(sample.duration, sample.gains, sample.references, H + sign * step * change, numbers(sample))
        )
        for sign in (1.0, -1.0)
    ]
    difference = (moved[0]["slope"] - moved[1]["slope"]) / (2.0 * step)
    expected = -found["response"] @ np.linalg.pinv(H) @ change @ found["error"]
    np.testing.assert_allclose(difference, expected, atol=1e-5 * np.abs(expected).max())  # as for time


def test_on_one_orbit_both_phases_apply_the_same_torques() -> None:
    """The same motion, its references over time and over the configuration."""
    for sample, _ in samples(10, seed=27):
        here, timed = on_orbit(sample)
        ours = evaluated(here, packed(here))
        theirs = evaluated(timed, pack(timed.duration, timed.gains, timed.references, H), on_time=True)
        for kind in ("acceleration", "torques"):
            np.testing.assert_allclose(ours[kind], theirs[kind], atol=1e-9 * np.abs(theirs[kind]).max())


def test_equals_the_checks_own_dense_solution() -> None:
    for sample, _ in samples(10, seed=28):
        dynamics = OutputDynamics(
            weights=H,
            references=sample.references,
            duration=sample.duration,
            gains=sample.gains,
            domain=DomainPhase(phase=PHASE, robot=robot("astro"), stance=STANCE),
            phase_numbers=numbers(sample),
        )
        q, v = sample.q[None], sample.v[None]
        motion = dynamics.solve(terms(Contacts(robot("astro"), STANCE.feet), q, v), np.array([sample.t]), q, v)
        ours = evaluated(sample, packed(sample))
        for found, expected in ((ours["acceleration"], motion.accelerations), (ours["torques"], motion.torques)):
            np.testing.assert_allclose(found.ravel(), expected[0], atol=1e-8 * np.abs(expected).max())


def test_outputs_that_hold_the_phase_are_seen_in_the_pivot() -> None:
    """A phase of one controlled joint: its own output says where it is, so nothing drives it."""
    model = robot("astro")
    q, v, t = ca.SX.sym("q", model.size), ca.SX.sym("v", model.size), ca.SX.sym("t")
    held = ConfigurationPhase({"D1": {"fl_knee": 1.0}})
    constraints = VirtualConstraints.symbols(11, model.size - 3, ORDER, held)
    rates = constraints.phase_rates(model, STANCE, t, q, v)
    closed = linearise(Contacts(model, STANCE.feet), LAWS["pinv"], q, v, rates, constraints)
    function = ca.Function("pivot", [q, v, constraints.packed()], [closed.pivot])
    for sample, _ in samples(3, seed=29):
        place, joint = np.array([sample.q[model.coordinate_index("fl_knee")]]), model.coordinate_index("fl_knee") - 3
        references = sample.references.copy()
        references[joint] = np.linspace(place[0] - 0.04, place[0] + 0.06, ORDER + 1)  # theta itself over the phase
        p = pack(sample.duration, sample.gains, references, H, np.array([place[0] - 0.04, place[0] + 0.06]))
        assert float(function(sample.q, sample.v, p)) < 1e-9
        assert evaluated(sample, packed(sample))["pivot"].item() > 1e-6


def on_orbit(sample: Sample) -> tuple[Sample, Sample]:
    """The sample with references over the configuration and over time, with both of which all of y_a moves."""
    second = np.random.default_rng(30).normal(0.0, 5.0, sample.q.size - 3)
    for _ in range(2):  # once for the controlled coordinates, once more for those that follow
        curve = _curve(sample.q[3:], sample.v[3:] * sample.duration, second * sample.duration**2, 0.4)
        timed = Sample(sample.q, sample.v, 0.4 * sample.duration, sample.duration, sample.gains, curve)
        p = pack(timed.duration, timed.gains, timed.references, H)
        acceleration = evaluated(timed, p, on_time=True)["acceleration"].ravel()
        second = acceleration[3:]
    q, v, a = (ca.SX.sym(letter, sample.q.size) for letter in "qva")
    domain = DomainPhase(phase=PHASE, robot=robot("astro"), stance=STANCE)
    rates = domain.rates(ca.SX(0), ca.SX(sample.duration), q, v, ca.SX(ca.DM(numbers(sample))))
    along = ca.Function("along", [q, v, a], [rates.rate, rates.second(a)])
    rate, bent = (float(part) for part in along(sample.q, sample.v, acceleration))
    slope = sample.v[3:] / rate
    curve = _curve(sample.q[3:], slope, (second - slope * bent) / rate**2, 0.4)
    return Sample(sample.q, sample.v, sample.t, sample.duration, sample.gains, curve), timed


def _curve(value: Vector, slope: Vector, curvature: Vector, phase: float) -> Matrix:
    """Coefficients of parabolas with a value, slope and curvature at a phase, written in order 4."""
    nodes = np.linspace(0.0, 1.0, ORDER + 1)
    away = nodes - phase
    values = value[:, None] + slope[:, None] * away + 0.5 * curvature[:, None] * away**2
    basis = evaluate(np.eye(ORDER + 1), nodes)[0]
    return np.linalg.solve(basis, values.T).T


@pytest.mark.parametrize("beyond", [-0.4, 1.6])
def test_far_outside_the_domain_the_curves_are_parabolas(beyond: float) -> None:
    """The third derivative of the commanded acceleration's curve over the phase vanishes there."""
    model = robot("astro")
    constraints = VirtualConstraints.symbols(11, model.size - 3, ORDER, PHASE)
    s = ca.SX.sym("s")
    third = ca.jacobian(_basis(s, constraints)[2], s)
    assert not np.any(np.asarray(ca.Function("third", [s], [ca.densify(third)])(beyond)))
