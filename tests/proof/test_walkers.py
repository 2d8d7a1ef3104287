"""Walkers with listed multipliers (Goswami, Thuilot, Espiau 1998): proofs agree to half a unit of the last digit."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from examples import three_link_walker
from flint import arb, arb_mat

from amble.hybrid import HybridSystem
from amble.proof import Proof, Settings, prove, verify
from amble.proof.arithmetic import column, from_decimals, working_precision
from amble.proof.return_map import ReturnMap
from amble.simulation import simulate
from amble.stability import fixed_point
from tests.periodic import compass_gait, van_der_pol

SLOPE = float(np.deg2rad(4.5))
COMPASS = np.array([0.2313, -0.3884, -1.1502, -0.1664])  # near the orbit that closes after one step
SETTINGS = Settings(basin=0.0)


def real_parts(proof: Proof, width: float = 1e-8) -> list[float]:
    """Middles of the multipliers by falling size; every ball is less wide than is said."""
    for pair, other in proof.proved.multipliers:
        assert float(pair[1]) - float(pair[0]) < width
        assert float(other[0]) <= 0.0 <= float(other[1])
    middles = [(float(low) + float(high)) / 2 for (low, high), _ in proof.proved.multipliers]
    return sorted(middles, key=abs, reverse=True)


@pytest.mark.slow
def test_the_compass_gait_of_one_step_is_unstable() -> None:
    system = compass_gait(SLOPE)
    proof = prove(system, COMPASS, SETTINGS)
    assert not proof.stable
    assert proof.proved.unstable is not None
    assert float(proof.proved.unstable) > 1.0
    assert real_parts(proof)[0] == pytest.approx(-1.10649740, abs=0.5e-8)
    assert all(float(high) - float(low) < 1e-8 for low, high in proof.proved.state.values())
    verify(proof, system)


@pytest.mark.slow
def test_the_compass_gait_of_two_steps_is_stable() -> None:
    """As a ring of two copies of the domain: the orbit closes after both."""
    system = compass_gait(SLOPE)
    once = fixed_point(system, COMPASS)
    trace = simulate(system, once.state + np.array([0.0, 0.0, 0.01, 0.0]), 100, 1e-10)
    twice = fixed_point(system, trace.section[-1], cycles=2)
    (domain,), (strike,) = system.domains, system.transitions
    domains = [replace(domain, name=name) for name in ("left", "right")]
    strikes = [replace(strike, source="left", target="right"), replace(strike, source="right", target="left")]
    ring = HybridSystem(domains, strikes, state_names=system.state_names)
    proof = prove(ring, twice.state, SETTINGS)
    assert proof.stable
    period = sum((float(low) + float(high)) / 2 for low, high in proof.proved.durations)
    assert period == pytest.approx(1.50550526, abs=0.5e-8)
    values = real_parts(proof)
    assert values[0] == pytest.approx(0.50984317, abs=0.5e-8)
    assert values[1:3] == pytest.approx([0.16300, 0.01224], abs=0.5e-5)
    verify(proof, ring)


@pytest.mark.slow
def test_the_three_link_walker() -> None:
    system = three_link_walker.three_link_walker()
    proof = prove(system, three_link_walker.find_orbit(system)[0].state, SETTINGS)
    assert proof.stable
    (duration,) = ((float(low) + float(high)) / 2 for low, high in proof.proved.durations)
    assert duration == pytest.approx(1.1084974, abs=0.5e-7)
    assert real_parts(proof)[0] == pytest.approx(0.57273, abs=0.5e-5)
    assert all(float(high) - float(low) < 1e-8 for low, high in proof.proved.state.values())
    # the rates before the impact, from those after it: the impact is linear in them, and the legs swap
    with working_precision(128):
        (leg,) = ReturnMap.of(system, 10, 1e-20).legs
        after = [from_decimals(*pair) for pair in proof.proved.state.values()]
        flat = leg.reset.balls([arb(0)], [after[1], after[0], after[2], arb(0), arb(0), arb(0)], [])[1]
        slope = arb_mat(6, 6, flat).transpose().tolist()
        before = arb_mat([row[3:] for row in slope[3:]]).solve(column(after[3:]))[0, 0]
        assert abs(before - arb("1.5525214")) <= arb("0.5e-7")


@pytest.mark.slow
def test_van_der_pol() -> None:
    proof = prove(van_der_pol(1.0), np.array([0.0, 2.2]), replace(SETTINGS, order=24))
    assert proof.stable
    (period,) = ((float(low) + float(high)) / 2 for low, high in proof.proved.durations)
    assert period == pytest.approx(6.66328685932, abs=0.5e-11)
    assert real_parts(proof)[0] == pytest.approx(8.596951e-4, abs=0.5e-10)
