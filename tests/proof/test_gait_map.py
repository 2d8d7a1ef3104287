"""A gait's closed loop proved; what has no proof is refused by name."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

import numpy as np
import pytest

from amble.control import MinimumPeak
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.hybrid import HybridSystem
from amble.proof import GAIT_SETTINGS, Proof, prove_gait
from amble.proof.gait_map import require_provable, require_smooth
from amble.stability import FixedPoint
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from tests.hybrids import travelling

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
