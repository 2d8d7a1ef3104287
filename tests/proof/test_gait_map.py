"""A gait's closed loop enclosed: against the simulator, and against points that move by the eliminated formulas."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest
from flint import arb

from amble.control import MinimumPeak
from amble.control.closed_loop import _flow_functions
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.constraints import REFERENCE_ORDER
from amble.gait.files import load_gait
from amble.hybrid import HybridSystem
from amble.proof import GAIT_SETTINGS, Proof, ProofError, load_proof, prove_gait, save_proof, verify
from amble.proof.arc import Arc, follow
from amble.proof.arithmetic import column, working_precision
from amble.proof.gait_map import gait_map, require_provable, require_smooth
from amble.proof.moving_set import MovingSet
from amble.proof.tape import Tape, record
from amble.stability import FixedPoint
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from tests.hybrids import travelling
from tests.proof.points import BITS, moved

RADIUS = 2.0**-64
DATA = Path(__file__).parents[1] / "data"


@lru_cache(maxsize=1)
def stabilised() -> tuple[Gait, HybridSystem, FixedPoint]:
    gait = load_gait(DATA / "stabilised-amble.json")
    return gait, *closed_loop_fixed_point(gait)


def test_feet_that_land_together_are_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"feet .*, .* land at once \(simultaneous guards\)"):
        require_provable(load_gait(DATA / "trot.json"))


def test_a_law_with_corners_is_refused(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="'peak' do not solve linear equations"):
        require_provable(replace(stabilised_gait, law=MinimumPeak()))


def test_a_breakpoint_along_the_orbit_is_refused() -> None:
    system = HybridSystem(
        [replace(travelling(0.0, 1).domains[0], breakpoints=(0.1, 0.3))], travelling(0.0, 1).transitions
    )
    require_smooth(system, [0.05])
    with pytest.raises(InputError, match=r"breakpoints \(1\) along domain"):
        require_smooth(system, [0.2])


@lru_cache(maxsize=2)
def eliminated(domain: int) -> Tape:
    """The field of a stance as the simulation has it: formulas without linear equations."""
    gait, _, _ = stabilised()
    stance = gait.pattern.solved[domain]
    outputs = len(gait.outputs.of(stance.name).coordinates)
    contacts = gait.pattern.contacts(stance)
    return record(_flow_functions(contacts, gait.law, stance, outputs, REFERENCE_ORDER, gait.outputs.phase)[0])


@lru_cache(maxsize=1)
def first_arc() -> tuple[Arc, list[arb]]:
    """The first stance from a box about the fixed point's start, with the start."""
    gait, system, found = stabilised()
    with working_precision(128):
        leg = gait_map(gait, system, 24, 1e-26).legs[0]
        centre = [arb(float(value)) for value in found.state]
        return follow(leg, MovingSet.about(centre, [arb(RADIUS)] * len(centre)), 24, 1e-26), centre


@pytest.mark.slow
def test_the_first_stance_agrees_with_the_simulator() -> None:
    """The simulator's tolerance is 1e-12, its variational equations' 1e-10 of the largest entry."""
    arc, _ = first_arc()
    _, system, found = stabilised()
    assert float(arc.duration) == pytest.approx(found.monodromy.durations[0], abs=1e-12)
    derivative = np.array([float(value) for value in arc.after.derivative().entries()]).reshape(36, 36)
    factor = found.monodromy.factors[0]
    assert derivative == pytest.approx(factor, abs=1e-9 * np.abs(factor).max())
    assert len(system.domains) == 2


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1])
def test_random_starts_land_in_the_image(seed: int) -> None:
    """Integrated in 60 digits by extrapolation of the eliminated formulas: another method and other formulas."""
    arc, centre = first_arc()
    gait, system, _ = stabilised()
    draws = np.random.default_rng(seed)
    with working_precision(BITS):
        parameters = [arb(float(value)) for value in system.domains[0].parameters]
        leg = gait_map(gait, system, 24, 1e-26).legs[0]

        def rate(clock: arb, state: list[arb]) -> list[arb]:
            return [value.mid() for value in eliminated(0).balls([clock], state, parameters)[0]]

        offset = [arb(int(k)) * RADIUS / 2**20 for k in draws.integers(-(2**20), 2**20 + 1, len(centre))]
        clock = arc.duration.mid()
        end = moved(rate, arb(0), [c + o for c, o in zip(centre, offset, strict=True)], clock, 24, 18)
        for _ in range(2):  # to the guard, on which the end lies to 1e-17
            value, along, drift = leg.exit.at(clock, end, parameters)
            field = rate(clock, end)
            late = (value / sum((a * r for a, r in zip(along, field, strict=True)), start=drift)).mid()
            end = [(x - late * r).mid() for x, r in zip(end, field, strict=True)]
            clock = (clock - late).mid()
        assert arc.duration.contains(clock)
        image, _, _ = leg.reset.balls([clock], end, parameters)
        reached = (arc.after.derivative() * column(offset)).entries()
        for ball, extra, value in zip(arc.after.middle(), reached, image, strict=True):
            assert (ball + extra).overlaps(value + arb(0, 1e-27))
            assert float((ball + extra).rad()) < 1e-3 * RADIUS


@pytest.mark.slow
def test_less_friction_than_is_used_is_refused() -> None:
    gait, system, found = stabilised()
    slippery = replace(gait, pattern=replace(gait.pattern, ground=replace(gait.pattern.ground, friction=0.4)))
    with working_precision(128):
        prepared = gait_map(slippery, system, 24, 1e-24)
        centre = [arb(float(value)) for value in found.state]
        with pytest.raises(ProofError, match=r"margin of friction of 'rl' .* in domain 'D1'"):
            prepared(centre, [arb(1e-20)] * len(centre))


@pytest.fixture(scope="module")
def proof() -> Proof:
    return prove_gait(stabilised()[0], GAIT_SETTINGS)


@pytest.mark.slow
def test_the_amble_of_reproduce_is_proved(proof: Proof, tmp_path: Path) -> None:
    _, system, found = stabilised()
    matrix = found.monodromy.matrix
    estimate = sorted(np.abs(np.linalg.eigvals(matrix)))[-3]  # without the translations along x and y
    assert proof.half
    assert proof.found.rate is not None
    assert estimate**2 - 1e-9 < proof.found.rate**2 < estimate**2 + 1e-3
    for name, value in zip(system.state_names, found.state, strict=True):
        low, high = map(float, proof.proved.state[name])
        assert low - 1e-10 < value < high + 1e-10
    assert all(float(low) > 0.0 for margins in proof.proved.margins for low in margins.values())
    verify(load_proof(save_proof(tmp_path / "proof.json", proof)), stabilised()[0])
