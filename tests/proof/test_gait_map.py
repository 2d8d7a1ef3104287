"""A gait's closed loop proved; what has no proof is refused by name."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from flint import arb

from amble.control import MinimumPeak
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.hybrid import HybridSystem
from amble.proof import ProofError
from amble.proof.arithmetic import working_precision
from amble.proof.gait_map import gait_map, require_provable, require_smooth
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from tests.hybrids import travelling
from tests.proof import gaits

DATA = Path(__file__).parents[1] / "data"


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


@pytest.mark.slow
def test_less_friction_than_is_used_is_refused() -> None:
    gait = gaits.stabilised()
    system, found = closed_loop_fixed_point(gait)
    slippery = replace(gait, pattern=replace(gait.pattern, ground=replace(gait.pattern.ground, friction=0.4)))
    with working_precision(128):
        prepared = gait_map(slippery, system, 24, 1e-24)
        centre = [arb(float(value)) for value in found.state]
        with pytest.raises(ProofError, match=r"margin of friction of 'rl' .* in domain 'D1'"):
            prepared(centre, [arb(1e-20)] * len(centre))
