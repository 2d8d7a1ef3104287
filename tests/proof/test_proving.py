"""Gaits proved: against the simulator's estimate, and against points that move by other formulas and another method."""

from __future__ import annotations

import resource
import time

import numpy as np
import pytest
from flint import arb

from amble.control.closed_loop import _flow_functions
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.constraints import REFERENCE_ORDER
from amble.proof import Proof, Settings, prove_gait, verify
from amble.proof.arithmetic import column, exact_matrix, working_precision
from amble.proof.gait_map import gait_map
from amble.proof.quotient import translations
from amble.proof.tape import Tape, record
from amble.stability import FixedPoint
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.stabilize import stabilization
from amble.workflow.specified import pose, solve
from tests.proof import gaits
from tests.proof.points import BITS, Rate, landed

STEPS, COLUMNS, ERROR = 12, 14, 1e-26
"""Of an integration through a stance, and its error: doubling the steps changes less."""


@pytest.mark.parametrize(("what", "value"), [("bits", 63), ("order", 41), ("tolerance", 0.0), ("basin", 2.0)])
def test_settings_are_bounded(what: str, value: float) -> None:
    with pytest.raises(InputError):
        Settings(**{what: value})


@pytest.mark.slow
def test_the_gait_of_the_tests_is_proved() -> None:
    require_agreement(gaits.proof(), gaits.stabilised())


@pytest.mark.slow
def test_the_amble_of_reproduce_is_proved() -> None:
    """The gait of `make run`, anew: in less than 15 minutes of processor time, with less than 4 GB, and verified."""
    gait = stabilization(solve(pose())).gait
    before = time.process_time()
    proof = prove_gait(gait)
    assert time.process_time() - before < 900.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 4 * 2**20  # kB
    require_agreement(proof, gait)
    verify(proof, gait)


def require_agreement(proof: Proof, gait: Gait) -> FixedPoint:
    """The proof's bound is within 1e-3 of the simulator's estimate, and its box where the simulator's orbit is."""
    system, found = closed_loop_fixed_point(gait)
    estimate = sorted(np.abs(np.linalg.eigvals(found.monodromy.matrix)))[-3]  # without the translations along x and y
    assert proof.half
    assert proof.found.rate is not None
    assert estimate**2 - 1e-9 < proof.found.rate**2 < estimate**2 + 1e-3
    for name, value in zip(system.state_names, found.state, strict=True):
        low, high = map(float, proof.proved.state[name])
        assert low - 1e-10 < value < high + 1e-10
    assert all(float(low) > 0.0 for margins in proof.proved.margins for low in margins.values())
    return found


def eliminated(gait: Gait, domain: int) -> Tape:
    """The field of a stance as the simulation has it: formulas without linear equations."""
    stance = gait.pattern.solved[domain]
    outputs = len(gait.outputs.of(stance.name).coordinates)
    contacts = gait.pattern.contacts(stance)
    return record(_flow_functions(contacts, gait.law, stance, outputs, REFERENCE_ORDER, gait.outputs.phase)[0])


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_starts_land_in_the_enclosures(seed: int) -> None:
    """Half a cycle from a start in the box: in 60 digits, by extrapolation of the eliminated formulas.

    x* in its ball, D over the box: a start x lands in x* + Xi s + D (x - x*), s the proved shift.
    """
    gait, proof, orbit = gaits.stabilised(), gaits.proof(), gaits.again().orbit
    system, _ = closed_loop_fixed_point(gait)
    draws = np.random.default_rng(seed)
    with working_precision(BITS):
        prepared = gait_map(gait, system, proof.found.order, 1.0)
        steps = draws.integers(-(2**20), 2**20 + 1, len(orbit.centre))
        start = [c + int(k) * r / 2**20 for c, k, r in zip(orbit.centre, steps, orbit.radii, strict=True)]
        state = start
        for number, (leg, duration) in enumerate(zip(prepared.legs, orbit.durations, strict=True)):
            clock, state = landed(
                leg, rate_of(eliminated(gait, number), leg.parameters), state, duration.mid(), STEPS, COLUMNS
            )
            assert duration.contains(clock)
        along = exact_matrix(translations(system, np.array([float(value) for value in orbit.centre])))
        offset = column([a - b for a, b in zip(start, orbit.state, strict=True)])
        image = column(orbit.state) + along * column(orbit.shift) + orbit.derivative * offset
        for ball, value in zip(image.entries(), state, strict=True):
            assert ball.overlaps(value + arb(0, ERROR))
            assert float(ball.rad()) < 1e-3 * float(orbit.radii[0])


def rate_of(tape: Tape, parameters: tuple[arb, ...]) -> Rate:
    return lambda clock, state: [value.mid() for value in tape.balls([clock], state, parameters)[0]]
