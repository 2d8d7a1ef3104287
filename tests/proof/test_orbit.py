"""Orbits with known answers: what is proved holds them, and what is wrong is not proved."""

from __future__ import annotations

from dataclasses import replace

import casadi as ca
import numpy as np
import pytest
from examples import rimless_wheel, simplest_walker
from flint import arb

from amble.errors import InputError
from amble.hybrid import Domain, HybridSystem, Transition
from amble.proof import ProofError
from amble.proof.arithmetic import working_precision
from amble.proof.basin import prove_basin
from amble.proof.orbit import ProvedOrbit, prove_orbit, refined
from amble.proof.quotient import contracts
from amble.proof.return_map import ReturnMap
from amble.proof.tape import record
from amble.simulation import simulate
from amble.stability import fixed_point
from tests.hybrids import bouncing_ball, travelling, two_phases
from tests.periodic import ball_on_table, relay_loop

RADIUS = 1e-15
BITS = 128


def proved(system: HybridSystem, guess: np.ndarray, order: int = 14, radius: float = RADIUS) -> ProvedOrbit:
    with working_precision(BITS):
        prepared = ReturnMap.of(system, order, 1e-7 * radius)
        centre = refined(prepared, fixed_point(system, guess).state, 1e-3 * radius)
        return prove_orbit(prepared, centre, [arb(radius)] * len(centre))


@pytest.mark.parametrize(("spokes", "slope"), [(6, 0.2), (8, 0.15), (12, 0.05)])
def test_rimless_wheels_in_closed_form(spokes: int, slope: float) -> None:
    """Enclosures hold the closed forms, of the doubles that the example writes, and are less wide than 1e-8."""
    system = rimless_wheel.rimless_wheel(spokes, slope)
    orbit = proved(system, np.array([slope - np.pi / spokes, rimless_wheel.known_rate(spokes, slope)]))
    with working_precision(BITS):
        share = arb(float(np.cos(2 * np.pi / spokes))) ** 2
        start, end = arb(slope - np.pi / spokes), arb(slope + np.pi / spokes)
        gained = 2 * (start.cos() - end.cos())
        rate = (share * gained / (1 - share)).sqrt()
        assert orbit.state[1].contains(rate)
        assert float(orbit.state[1].rad()) < 1e-16
        multiplier = max(orbit.multipliers, key=lambda value: float(abs(value).mid()))
        assert multiplier.real.contains(share)
        assert float(multiplier.real.rad()) < 0.5e-8
        assert orbit.stable
        assert float(share) < orbit.rate < float(share) + 1e-4


def test_the_listed_values_of_the_simplest_walker() -> None:
    """Within half a unit of the last digit that is listed; the short step is proved unstable."""
    long, short = (proved(*step(), radius=1e-16) for step in (simplest_walker.long_step, simplest_walker.short_step))
    for orbit, theta, rate, period in (
        (long, "0.2003109005442", "-0.1998324730050", "3.88246375"),
        (short, "0.1939373698102", "-0.2038669274420", "3.09610587"),
    ):
        for ball, listed in ((orbit.state[0], theta), (orbit.state[2], rate), (orbit.durations[0], period)):
            assert is_listed(ball, listed)
            assert float(ball.rad()) < 0.5e-8
        parts = [part for value in orbit.multipliers for part in (value.real, value.imag)]
        assert all(float(part.rad()) < 0.5e-8 for part in parts)
    assert long.stable
    assert 0.58911319 < long.rate < 0.58911319 + 1e-4  # above the multipliers by a share of the distance to 1
    upper = max(long.multipliers, key=lambda value: float(value.imag))
    assert is_listed(upper.real, "-0.19009984")
    assert is_listed(upper.imag, "0.55759878")
    assert not short.stable
    assert short.unstable is not None
    assert is_listed(short.unstable, "4.00386436")
    largest, second = sorted((value.real for value in short.multipliers), key=float)[:-3:-1]
    assert is_listed(largest, "4.00386436")
    assert is_listed(second, "0.45958959")


def is_listed(ball: arb, listed: str) -> bool:
    """Whether all numbers of a ball are what a list rounded, by half a unit of its last digit."""
    with working_precision(BITS):
        unit = arb(10) ** -len(listed.partition(".")[2])
        return bool(abs(ball - arb(listed)) <= unit / 2)


def test_the_listed_rate_of_a_rimless_wheel() -> None:
    orbit = proved(*rimless_wheel.rolling())
    assert is_listed(orbit.state[1], "0.363931615")
    assert any(is_listed(value.real, "0.25") for value in orbit.multipliers)


def test_the_listed_multipliers_of_a_ball_on_a_vibrating_table() -> None:
    """The table that they belong to follows from their sum, and the amplitude from the table."""
    pull, share = (2.51655601 + 0.09934212 + 1.25) / 1.5**2, np.pi / 3
    start = np.array([pull, np.pi, np.arctan2(pull, share)])
    table = ball_on_table(0.5, np.hypot(pull, share))
    quiet = [replace(bounce, dead_time=0.5) for bounce in table.transitions]  # in which the ball leaves the table
    orbit = proved(HybridSystem(table.domains, quiet, state_names=table.state_names), start)
    values = sorted((value.real for value in orbit.multipliers), key=float)
    assert is_listed(values[0], "-2.51655601")
    assert is_listed(values[1], "-0.09934212")
    assert orbit.unstable is not None
    assert is_listed(orbit.unstable, "2.51655601")


def test_two_domains_clocks_and_parameters() -> None:
    """All that a map can have, against the estimate by variational equations to its tolerance."""
    system = two_phases()
    found = fixed_point(system, np.array([0.2, 0.9, 0.3]))
    orbit = proved(system, found.state)
    assert [float(value) for value in orbit.state] == pytest.approx(found.state, abs=1e-9)
    matrix = np.array([[float(orbit.derivative[i, j]) for j in range(3)] for i in range(3)])
    assert matrix == pytest.approx(found.monodromy.matrix, abs=1e-7)


def test_a_relay_without_dead_time() -> None:
    orbit = proved(relay_loop(0.1), fixed_point(relay_loop(0.1), np.array([-0.5, -0.3, -0.1])).state)
    assert orbit.stable
    assert float(orbit.durations[0]) == pytest.approx(float(orbit.durations[1]), abs=1e-12)  # its halves are symmetric
    assert is_listed(max((value.real for value in orbit.multipliers), key=float), "0.025927482")
    # half a cycle, closed by x -> -x: its multiplier squared is that of the cycle
    (plus, _), (leaving, _) = relay_loop(0.1).domains, relay_loop(0.1).transitions
    x = ca.SX.sym("x", 3)
    mirror = ca.Function("mirror", [ca.SX.sym("t"), x, ca.SX.sym("p", 0)], [-x], ["t", "x", "p"], ["state"])
    half = HybridSystem([plus], [replace(leaving, target="plus", reset=mirror)])
    closed = proved(half, np.array([float(value) for value in orbit.state]))
    assert any(is_listed(abs(value.real), "0.161020129") for value in closed.multipliers)


def test_an_orbit_is_proved_modulo_translations() -> None:
    """travelling() with its turn left out: x and y are neutral, the heading is reversed by its reset."""
    system = travelling(0.0, -1)
    kept = HybridSystem(system.domains, system.transitions, system.symmetries[:1], system.state_names)
    found = fixed_point(kept, np.array([0.0, 0.2, 0.0, 0.0, 0.0]))
    orbit = proved(kept, found.state)
    # y and the heading return reversed, with multiplier -1: the orbit exists, its stability is not proved
    assert not orbit.stable
    assert orbit.unstable is None
    assert float(orbit.shift[0]) == pytest.approx(found.shift["x"], abs=1e-9)


def test_an_orbit_that_is_stable_up_to_a_turn() -> None:
    """The same with its turn: at the fixed point the generator is reversed, so it is a direction of the quotient."""
    system = travelling(0.0, -1)
    kept = HybridSystem(system.domains, system.transitions, system.symmetries[:2], system.state_names)
    found = fixed_point(kept, np.array([0.0, 0.2, 0.0, 0.0, 0.0]))
    x = ca.SX.sym("x", 5)
    turn = record(ca.Function("turn", [x], [ca.densify(system.symmetries[2].generator(x))]))
    with working_precision(BITS):
        prepared = ReturnMap.of(kept, 14, 1e-22)
        centre = refined(prepared, found.state, 1e-3 * RADIUS)
        upright = prove_orbit(prepared, centre, [arb(RADIUS)] * 5)
        turned = prove_orbit(replace(prepared, turns=(turn,)), centre, [arb(RADIUS)] * 5)
        assert prove_basin(replace(prepared, turns=(turn,)), turned, 1e-3)[0] is None
    assert not upright.stable  # the heading has the multiplier -1
    assert turned.stable
    estimate = np.linalg.eigvals(found.monodromy.matrix)
    assert sorted(np.abs(estimate))[2:] == pytest.approx([1.0] * 3, abs=1e-9)
    assert turned.rate == pytest.approx(sorted(np.abs(estimate))[1], abs=1e-4)


def test_a_state_that_is_no_fixed_point_is_refused() -> None:
    system, _ = rimless_wheel.rolling()
    with working_precision(BITS):
        prepared = ReturnMap.of(system, 14, 1e-22)
        centre = [arb(rimless_wheel.SLOPE - np.pi / rimless_wheel.SPOKES), arb(rimless_wheel.known_rate() + 1e-3)]
        with pytest.raises(ProofError, match="interval Newton image leaves the box in 'rate'"):
            prove_orbit(prepared, centre, [arb(RADIUS)] * 2)


def test_a_box_that_is_too_small_is_refused() -> None:
    """The fixed point lies outside of it: the centre is some 1e-16 away."""
    system, start = rimless_wheel.rolling()
    with working_precision(BITS):
        prepared = ReturnMap.of(system, 14, 1e-22)
        centre = [arb(float(value)) for value in fixed_point(system, start).state]
        with pytest.raises(ProofError, match="interval Newton image leaves the box"):
            prove_orbit(prepared, centre, [arb(1e-20)] * 2)


def test_no_exit_within_a_dead_time() -> None:
    """From a start whose guard is zero up to rounding there is a root at a clock of 1e-39 s, in the dead time."""
    system, guess = simplest_walker.long_step()
    found = fixed_point(system, guess)
    with working_precision(BITS):
        prepared = ReturnMap.of(system, 20, 1e-22)
        (arc,) = prepared([arb(float(value)) for value in found.state], [arb(2.0**-40)] * 4).arcs
    assert float(arc.duration) == pytest.approx(found.period, abs=1e-9)


def test_the_weight_of_another_orbit_and_a_small_rate_are_refused() -> None:
    system, start = rimless_wheel.rolling()
    orbit = proved(system, start)
    with working_precision(BITS):
        assert contracts(orbit.derivative, orbit.weight, orbit.rate)
        assert not contracts(orbit.derivative, np.eye(2), orbit.rate)
        assert not contracts(orbit.derivative, orbit.weight, 0.99 * orbit.rate)


@pytest.mark.parametrize("share", [0.5, 0.9])
def test_random_starts_land_in_the_image(share: float) -> None:
    """The image of a box by the enclosure holds the simulated images of points of it, up to the simulator's 1e-11."""
    system, start = rimless_wheel.rolling()
    radius = 1e-5 * share
    with working_precision(BITS):
        image = ReturnMap.of(system, 14, 1e-12)([arb(float(v)) for v in start], [arb(radius)] * 2).image
    draws = np.random.default_rng(4)
    for _ in range(20):
        after = simulate(system, start + draws.uniform(-radius, radius, 2), 1, 1e-12).events[0].after
        for ball, value in zip(image, after, strict=True):
            assert float(ball.lower()) - 1e-11 <= value <= float(ball.upper()) + 1e-11


def test_what_cannot_be_proved_says_so() -> None:
    ball = bouncing_ball()
    with working_precision(BITS):
        # released on the floor at rest: never leaves it, so nothing is crossed transversally
        prepared = ReturnMap.of(ball, 10, 1e-20)
        with pytest.raises(ProofError, match="in domain 'flight'"):
            prepared([arb(0), arb(0)], [arb(1e-10)] * 2)


def test_compiled_code_is_refused() -> None:
    """A lookup table is no expression; nor is anything that calls a library."""
    t, z, p = ca.MX.sym("t"), ca.MX.sym("x"), ca.MX.sym("p", 0)
    table = ca.interpolant("table", "bspline", [[0, 1, 2, 3, 4]], [0, 1, 2, 3, 4])
    domain = Domain(name="d", field=ca.Function("f", [t, z, p], [table(z)], ["t", "x", "p"], ["rate"]))
    x = ca.SX.sym("x", 1)
    out = Transition.from_expressions("d", "d", x, x - 1, 0 * x, +1)
    with pytest.raises(InputError, match="cannot be enclosed"):
        ReturnMap.of(HybridSystem([domain], [out]), 10, 1e-20)
