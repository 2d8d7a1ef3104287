"""Mirrored gaits written out: the same motion under the same law, by the check and by the return map."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from amble.errors import InputError
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.gait.unfolding import unfolded
from amble.simulation import simulate
from amble.verification.check import check
from tests.conftest import DATA


def test_the_motion_passes_its_check(stabilised_gait: Gait) -> None:
    """All rows of a gait without a mirror: dynamics, impacts, curves, limits, and that it comes back to its entry."""
    whole = unfolded(stabilised_gait)
    assert not whole.pattern.mirrored
    assert len(whole.domains) == 2 * len(stabilised_gait.domains)
    assert whole.period == pytest.approx(stabilised_gait.period, rel=1e-15)
    assert check(whole).passed
    assert unfolded(whole) is whole


@pytest.mark.parametrize(
    "name", ["stabilised-amble", pytest.param("stabilised-trot-one-by-one", marks=pytest.mark.slow)]
)
def test_the_closed_loop_is_the_same(name: str) -> None:
    """A cycle from states beside the orbit: the same code between two mirrors, and written out; integrators of 1e-9."""
    gait = load_gait(DATA / f"{name}.json")
    whole, rng = unfolded(gait), np.random.default_rng(4)
    assert gait.feedback is not None
    systems = closed_loop(gait), closed_loop(whole)
    for _ in range(2):
        start = gait.feedback.start + 1e-3 * rng.normal(size=gait.feedback.start.size)
        ends = [simulate(system, start, 1, 1e-9, samples=2).section[-1] for system in systems]
        np.testing.assert_allclose(ends[0], ends[1], atol=1e-7)


def test_what_has_no_known_mirror_is_refused(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="control law 'impedance'"):
        unfolded(replace(stabilised_gait, control=Impedance()))
