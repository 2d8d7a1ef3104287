"""Gaits proved: against the simulator's estimate, and against points that move by other formulas and another method."""

from __future__ import annotations

import resource
import time
from dataclasses import replace
from itertools import islice

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.impedance import Impedance
from amble.proof import Proof, ProofError, Settings, prove_gait, verify
from amble.proof.basin import NO_TURNS
from amble.proof.verification import recomputed, require_claims
from amble.stability import FixedPoint
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from amble.stability.stabilize import stabilization
from amble.workflow.specified import pose, solve
from tests.proof import gaits
from tests.proof.altered import altered


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
    gait = stabilization(solve(pose(None))).gait
    before = time.process_time()
    proof = prove_gait(gait)
    assert time.process_time() - before < 900.0
    assert resource.getrusage(resource.RUSAGE_SELF).ru_maxrss < 4 * 2**20  # kB
    require_agreement(proof, gait)
    verify(proof, gait)


@pytest.mark.slow
def test_the_same_orbit_under_impedance_is_proved_up_to_its_turn() -> None:
    """The references' cuts are met one by one; verified; other gains and files with one number moved are refused."""
    gait = gaits.sprung()
    proof = prove_gait(gait)
    found = require_agreement(proof, gait)
    assert len(found.state) - len(proof.found.weight) == 3  # x, y and the turn about the vertical
    assert proof.found.rate is not None
    assert 0.659 < proof.found.rate**2 < 0.661  # docs/theory/impedance.md: 0.660
    assert proof.basin_limit == NO_TURNS
    again = recomputed(proof, gait)
    require_claims(proof.proved, again)
    for _, file in islice(altered(proof, again, np.random.default_rng(0)), 100):
        with pytest.raises(ProofError, match=r"does not hold what is computed|does not follow"):
            require_claims(file.proved, again)
    with pytest.raises(InputError, match="of another system"):
        verify(proof, replace(gait, control=Impedance(swing_damping=1.2)))


def require_agreement(proof: Proof, gait: Gait) -> FixedPoint:
    """The proof's bound is within 1e-3 of the simulator's estimate, and its box where the simulator's orbit is.

    The neutral directions, which the proof leaves out, have the largest multipliers.
    """
    system, found = closed_loop_fixed_point(gait)
    estimate = sorted(np.abs(np.linalg.eigvals(found.monodromy.matrix)))[len(proof.found.weight) - 1]
    assert proof.half
    assert proof.found.rate is not None
    assert estimate**2 - 1e-9 < proof.found.rate**2 < estimate**2 + 1e-3
    for name, value in zip(system.state_names, found.state, strict=True):
        low, high = map(float, proof.proved.state[name])
        assert low - 1e-10 < value < high + 1e-10
    assert all(float(low) > 0.0 for margins in proof.proved.margins for low in margins.values())
    return found
