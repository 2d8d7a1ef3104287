"""Periodic orbits with values from an independent computation (extended precision, nothing shared with this package).

Digits are those that were given; Newton and the integrator leave about 1e-11.
"""

from __future__ import annotations

import dataclasses

import casadi as ca
import numpy as np
import pytest

from amble.errors import CertificateError, FallError, InputError, NotSolvedError, WorkError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.simulation import simulate
from amble.stability import FixedPoint, certify, difference_check, fixed_point, monodromy, multipliers
from amble.types import Vector
from tests.hybrids import bouncing_ball, travelling
from tests.periodic import ball_on_table, compass_gait, relay_loop, spring_mass_runner, van_der_pol

SLOPE = np.deg2rad(4.5)
COMPASS = np.array([0.2313, -0.3884, -1.1502, -0.1664])  # near the orbit that closes after one step
RUNNER = np.array([0.0, 1.0, 5.0, 0.0])


def test_van_der_pol() -> None:
    system = van_der_pol(1.0)
    orbit = fixed_point(system, np.array([0.0, 2.2]))
    assert orbit.period == pytest.approx(6.66328685932, abs=1e-10)
    assert certify(system, orbit.state).radius == pytest.approx(8.596951e-4, abs=5e-10)


@pytest.mark.parametrize("damping", [3.0, 5.0, *np.random.default_rng(1).uniform(2.0, 6.0, 3)])
def test_a_superstable_orbit_is_certified(damping: float) -> None:
    """The multiplier, exp of the integral of the divergence, is below what the integrator resolves."""
    system = van_der_pol(damping)
    orbit = fixed_point(system, np.array([0.0, 1.6 * damping]), time_limit=30.0)
    certificate = certify(system, orbit.state, time_limit=30.0)
    assert certificate.radius < 1e-4
    assert certificate.disagreement < 1e-7


def test_a_relay_with_hysteresis() -> None:
    system = relay_loop(0.1)
    orbit = fixed_point(system, np.array([-0.5, -0.3, -0.1]))
    assert multipliers(system, orbit.state).radius == pytest.approx(0.025927482, abs=5e-10)
    assert certify(system, orbit.state).radius < 1.0
    # half a cycle, closed by the mirror x -> -x: its multiplier squared is that of the cycle
    plus, leaving = system.domains[0], system.transitions[0]
    x = ca.SX.sym("x", 3)
    mirror = ca.Function("mirror", [ca.SX.sym("t"), x, ca.SX.sym("p", 0)], [-x])
    half = HybridSystem([plus], [dataclasses.replace(leaving, target="plus", reset=mirror)])
    closed = fixed_point(half, orbit.state)
    assert closed.period == pytest.approx(orbit.period / 2, abs=1e-10)
    assert multipliers(half, closed.state).radius == pytest.approx(0.161020129, abs=5e-10)


@pytest.mark.parametrize(
    ("restitution", "push"), [(0.5, None), *zip(*np.random.default_rng(2).uniform(0.2, 0.9, (2, 4)), strict=True)]
)
def test_a_ball_on_a_vibrating_table(restitution: float, push: float | None) -> None:
    """The multipliers have the sum 1 + e^2 + (1 + e)^2 a / g and the product e^2, a the table's acceleration."""
    pull = (2.51655601 + 0.09934212 + 1.25) / 1.5**2 if push is None else push
    share = np.pi * (1 - restitution) / (1 + restitution)
    phase = np.arctan2(pull, share)
    amplitude = np.hypot(pull, share)
    system = ball_on_table(restitution, amplitude)
    orbit = fixed_point(system, np.array([pull, np.pi, phase]))
    assert orbit.state == pytest.approx([pull, np.pi, phase], abs=1e-10)
    values = multipliers(system, orbit.state).multipliers
    known = np.roots([1.0, -(1 + restitution**2 - (1 + restitution) ** 2 * pull), restitution**2])
    for value in known:
        assert np.abs(values - value).min() < 1e-8
    if push is None:
        assert np.sort(values.real)[:2] == pytest.approx([-2.51655601, -0.09934212], abs=1e-8)


@pytest.fixture(scope="module")
def two_steps() -> FixedPoint:
    system = compass_gait(SLOPE)
    once = fixed_point(system, COMPASS)
    trace = simulate(system, once.state + np.array([0.0, 0.0, 0.01, 0.0]), 100, 1e-10)
    return fixed_point(system, trace.section[-1], cycles=2)


def test_the_compass_gait_at_period_one_is_unstable() -> None:
    system = compass_gait(SLOPE)
    orbit = fixed_point(system, COMPASS)
    values = multipliers(system, orbit.state).multipliers
    assert values[0] == pytest.approx(-1.10649740, abs=5e-9)
    assert (orbit.cycles, orbit.family) == (1, 0)


def test_the_compass_gait_at_period_two(two_steps: FixedPoint) -> None:
    system = compass_gait(SLOPE)
    assert two_steps.period == pytest.approx(1.50550526, abs=5e-9)
    assert two_steps.cycles == 2
    values = multipliers(system, two_steps.state, cycles=2).multipliers
    assert values[:3] == pytest.approx([0.50984317, 0.16300, 0.01224], abs=5e-6)
    assert values[0] == pytest.approx(0.50984317, abs=5e-9)
    certificate = certify(system, two_steps.state, cycles=2)
    assert certificate.radius == pytest.approx(0.50984317, abs=5e-9)
    assert certificate.to_dict()["cycles"] == 2
    assert certificate.mode is not None
    assert certificate.mode.difference < 1e-2


def test_a_guess_of_period_two_does_not_become_one_of_period_one_in_silence(two_steps: FixedPoint) -> None:
    with pytest.raises(NotSolvedError, match=r"the guess returns after 2 cycles, .* give cycles=2"):
        fixed_point(compass_gait(SLOPE), two_steps.state)


def logistic(growth: float) -> HybridSystem:
    """A cycle of one second that takes x to growth x (1 - x)."""
    x = ca.SX.sym("x", 2)
    wait = Domain.from_expressions("wait", x, ca.vertcat(1, 0))
    jump = Transition.from_expressions("wait", "wait", x, x[0] - 1, ca.vertcat(0, growth * x[1] * (1 - x[1])), +1)
    return HybridSystem([wait], [jump])


@pytest.mark.parametrize("growth", [3.2, *np.random.default_rng(5).uniform(3.05, 3.44, 4)])
def test_orbits_of_period_two_on_one_copy_of_the_domain(growth: float) -> None:
    """Known: x = (r + 1 +- sqrt((r - 3)(r + 1))) / 2r, multiplier 4 + 2r - r^2."""
    system = logistic(growth)
    known = (growth + 1 + np.sqrt((growth - 3) * (growth + 1))) / (2 * growth)
    orbit = fixed_point(system, np.array([0.0, known + 0.01]), cycles=2)
    assert orbit.state[1] == pytest.approx(known, abs=1e-10)
    assert (orbit.cycles, orbit.period) == (2, pytest.approx(2.0))
    spectrum = multipliers(system, orbit.state, cycles=2)
    assert spectrum.multipliers[0] == pytest.approx(4 + 2 * growth - growth**2, abs=1e-8)
    assert difference_check(system, orbit.state, cycles=2).matrix[1, 1] == pytest.approx(4 + 2 * growth - growth**2)
    with pytest.raises(NotSolvedError, match="give cycles=2"):
        fixed_point(system, np.array([0.0, known]))
    middle = 1 - 1 / growth
    assert fixed_point(system, np.array([0.0, middle + 0.01])).state[1] == pytest.approx(middle, abs=1e-10)
    # of a map of two cycles a point of period one is told
    assert fixed_point(system, np.array([0.0, middle + 1e-4]), cycles=2).cycles == 1


def test_a_guess_of_period_four() -> None:
    system = logistic(3.5)
    section = simulate(system, np.array([0.0, 0.3]), 400, samples=2).section
    for cycles in (1, 2):
        with pytest.raises(NotSolvedError, match="give cycles=4"):
            fixed_point(system, section[-1], cycles=cycles)
    assert fixed_point(system, section[-1], cycles=4).cycles == 4


def test_a_missing_dead_time_is_named() -> None:
    system = van_der_pol(1.0, dead_time=0.0)
    orbit = fixed_point(system, np.array([0.0, 2.2]))
    with pytest.raises(InputError, match=r"'swing->swing' is zero at the entry .* give the transition a dead_time"):
        certify(system, orbit.state)
    with pytest.raises(InputError, match="dead_time"):
        difference_check(system, orbit.state)


@pytest.mark.parametrize("seed", range(6))
def test_a_guess_before_the_section_is_no_orbit(seed: int) -> None:
    """Without a dead time it fires at once; whatever Newton makes of it is the orbit, or the reason is named."""
    guess = np.array([-(10.0 ** np.random.default_rng(seed).uniform(-6, -1)), 2.2])
    said = ""
    try:
        period = fixed_point(van_der_pol(1.0, dead_time=0.0), guess).period
    except NotSolvedError as error:
        period, said = 6.66328685932, str(error)
    assert period == pytest.approx(6.66328685932, abs=1e-9)
    assert not said or "give the transition a dead_time" in said or "equilibrium" in said


def energy(state: Vector) -> float:
    return float(state[2:] @ state[2:] / 2 + 9.81 * state[1])


@pytest.mark.parametrize("speed", [4.8, 5.0, *np.random.default_rng(6).uniform(4.7, 5.1, 3)])
def test_a_declared_invariant_keeps_its_value(speed: float) -> None:
    system = spring_mass_runner()
    guess = np.array([0.0, 1.0, speed, 0.0])
    orbit = fixed_point(system, guess)
    assert energy(orbit.state) == pytest.approx(energy(guess), rel=1e-11)
    assert orbit.family == 0
    certificate = certify(system, orbit.state)
    assert certificate.invariants["energy"] == pytest.approx(energy(guess), rel=1e-11)
    names = [row.name for row in certificate.rows()]
    assert "defect of invariant 'energy'" in names
    assert certificate.to_dict()["invariants"][0]["name"] == "energy"
    # the multipliers without the declaration: the same, and the 1 across the energies
    bare = np.abs(multipliers(spring_mass_runner(declared=False), orbit.state).multipliers)
    assert bare[0] == pytest.approx(1.0, abs=1e-8)
    assert bare[1] == pytest.approx(certificate.radius, abs=1e-8)


@pytest.mark.parametrize("seed", range(5))
def test_a_guess_on_a_family_stays_and_the_family_is_reported(seed: int) -> None:
    random = np.random.default_rng(seed)
    declared, bare = spring_mass_runner(), spring_mass_runner(declared=False)
    orbit = fixed_point(declared, RUNNER + np.array([0.0, 0.0, random.uniform(-0.3, 0.1), 0.0]))
    found = fixed_point(bare, orbit.state)
    assert found.state == pytest.approx(orbit.state, abs=1e-8)
    assert found.family == 1
    beside = orbit.state + 1e-3 * random.standard_normal(4)
    assert np.abs(fixed_point(bare, beside).state - beside).max() < 0.02
    with pytest.raises(CertificateError, match="spectral radius"):
        certify(bare, orbit.state)


def test_what_is_declared_and_not_conserved_is_refused() -> None:
    system = spring_mass_runner()
    orbit = fixed_point(system, RUNNER)
    z = ca.SX.sym("z", 4)
    false = dataclasses.replace(system.invariants[0], name="speed", function=ca.Function("speed", [z], [z[2]]))
    wrong = HybridSystem(system.domains, system.transitions, (), system.state_names, [false])
    with pytest.raises(CertificateError, match="defect of invariant 'speed'"):
        certify(wrong, orbit.state)


def test_an_equilibrium_is_no_orbit() -> None:
    """A focus: the section is crossed by every motion around it but by none at it."""
    with pytest.raises(NotSolvedError, match="equilibrium of the field"):
        fixed_point(van_der_pol(-0.5), np.array([0.0, 0.1]), iterations=200)


@pytest.mark.parametrize("restitution", [0.5, 0.8])
def test_a_fixed_point_where_events_accumulate_is_named(restitution: float) -> None:
    with pytest.raises(NotSolvedError, match=r"the cycle shrinks to nothing .*: its events accumulate"):
        fixed_point(bouncing_ball(restitution), np.array([0.0, 2.0]))


def two_exits(other: float, dead_time: float = 0.0) -> HybridSystem:
    """The travelling oscillation, with a second exit to a domain that leads back."""
    system = travelling(0.3, 1)
    x = ca.SX.sym("x", 5)
    aside = Domain.from_expressions("aside", x, 0.5 * ca.DM.ones(5))
    exits = [
        Transition.from_expressions("stride", "aside", x, x[0] - other, x, +1, dead_time=dead_time),
        Transition.from_expressions("aside", "stride", x, x[0] - 3, ca.vertcat(0, x[1:]), +1),
    ]
    return HybridSystem([*system.domains, aside], [*system.transitions, *exits], system.symmetries, system.state_names)


@pytest.mark.parametrize("other", [1.2, 3.0])
def test_an_exit_that_is_not_taken_does_not_matter(other: float) -> None:
    guess = np.array([0.0, 0.3, 1.0, -2.0, 0.4])
    plain = fixed_point(travelling(0.3, 1), guess)
    orbit = fixed_point(two_exits(other), guess)
    assert orbit.state == pytest.approx(plain.state, abs=1e-12)
    assert orbit.monodromy.transitions == ("stride->stride",)
    known = multipliers(travelling(0.3, 1), plain.state).multipliers
    assert multipliers(two_exits(other), orbit.state).multipliers == pytest.approx(known, abs=1e-10)
    assert certify(two_exits(other), orbit.state).radius == pytest.approx(np.abs(known[0]), abs=1e-8)


def test_the_exit_that_fires_first_is_taken() -> None:
    there = monodromy(two_exits(0.5), np.array([0.0, 0.3, 1.0, -2.0, 0.4]))
    assert there.transitions == ("stride->aside", "aside->stride")
    differences = difference_check(two_exits(0.5), np.array([0.0, 0.3, 1.0, -2.0, 0.4]))
    assert differences.matrix == pytest.approx(there.matrix, abs=1e-7)


def test_two_exits_at_once_have_no_derivative() -> None:
    with pytest.raises(WorkError, match=r"reaches the guards of 'stride->(stride|aside)' and .* at once"):
        monodromy(two_exits(1.0), np.array([0.0, 0.3, 1.0, -2.0, 0.4]))


@pytest.mark.parametrize("period", [32.0, *np.random.default_rng(7).uniform(15.0, 60.0, 2)])
def test_the_time_limit_reaches_every_part(period: float) -> None:
    """A cycle longer than the 10 s of the default."""
    x = ca.SX.sym("x", 2)
    wait = Domain.from_expressions("wait", x, ca.vertcat(1 / period, 0))
    jump = Transition.from_expressions("wait", "wait", x, x[0] - 1, ca.vertcat(0, 0.5 * x[1] + 0.1), +1)
    system = HybridSystem([wait], [jump])
    with pytest.raises(FallError, match="time_limit is 10 s"):
        fixed_point(system, np.zeros(2))
    orbit = fixed_point(system, np.zeros(2), time_limit=100.0)
    certificate = certify(system, orbit.state, time_limit=100.0)
    assert certificate.radius == pytest.approx(0.5)
    assert certificate.mode is not None


def test_a_trial_that_grazes_is_halved() -> None:
    """The full Newton step from 0 goes to 0.6, where the guard is only touched; the root is at 0.2."""
    x = ca.SX.sym("x", 3)
    wait = Domain.from_expressions("wait", x, ca.vertcat(1, 0, 0))
    residual = (0.2 - x[1]) * (1 + x[1] / 0.3)
    guard = (x[0] - 1) * ((x[0] - 1) ** 2 + ca.fmax(0.5 - x[1], 0)) + x[2]
    jump = Transition.from_expressions("wait", "wait", x, guard, ca.vertcat(0, x[1] + residual, 0), +1)
    system = HybridSystem([wait], [jump])
    with pytest.raises(WorkError, match="grazes"):
        monodromy(system, np.array([0.0, 0.6, 0.0]))
    assert fixed_point(system, np.zeros(3)).state[1] == pytest.approx(0.2, abs=1e-10)
