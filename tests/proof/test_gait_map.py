"""A gait's closed loop proved; what has no proof is refused by name."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from examples import rimless_wheel
from flint import arb

from amble.control import MinimumPeak
from amble.errors import InputError
from amble.gait import Gait
from amble.gait.files import load_gait
from amble.hybrid import HybridSystem
from amble.proof import ProofError, verification
from amble.proof.arithmetic import column, working_precision
from amble.proof.gait_map import gait_map, require_provable, require_smooth
from amble.proof.identity import system_hash
from amble.proof.leg import Leg
from amble.proof.return_map import Enclosure, ReturnMap
from amble.proof.switched_field import SwitchedField
from amble.stability.closed_loop_orbit import closed_loop_fixed_point
from tests.proof import gaits
from tests.proof.points import BITS, Rate, landed

DATA = Path(__file__).parents[1] / "data"
RADIUS, STEPS, COLUMNS, ERROR = 2.0**-46, 12, 8, 1e-18
"""Of the box; of an integration through a stance, and its error: 16 steps of 10 columns change 1e-28."""


def test_feet_that_land_together_are_refused_by_name() -> None:
    with pytest.raises(InputError, match=r"feet .*, .* land at once \(simultaneous guards\)"):
        require_provable(load_gait(DATA / "trot.json"))


def test_a_law_with_corners_is_refused(stabilised_gait: Gait) -> None:
    with pytest.raises(InputError, match="'peak' do not solve linear equations"):
        require_provable(replace(stabilised_gait, law=MinimumPeak()))


def marked_map() -> ReturnMap:
    """A small system that stands for a gait's loop; its law is known to be smooth until 0.1 s alone."""
    rolling = rimless_wheel.rolling()[0]
    marked = HybridSystem([replace(rolling.domains[0], breakpoints=(0.1,))], rolling.transitions, rolling.symmetries)
    with working_precision(64):
        prepared = ReturnMap.of(marked, 4, 0.0)
        (leg,) = prepared.legs
        return replace(prepared, legs=(replace(leg, field=SwitchedField((leg.field,), (arb(0.1),))),))


def test_an_orbit_longer_than_a_law_of_stretches_is_refused() -> None:
    require_smooth(marked_map(), [0.05])
    with pytest.raises(
        InputError, match=r"in domain 'stance', 0\.2 s long, the control law is not smooth after 0\.1 s"
    ):
        require_smooth(marked_map(), [0.2])


def test_a_proof_of_an_orbit_longer_than_its_law_is_refused_before_it_is_verified(
    stabilised_gait: Gait, monkeypatch: pytest.MonkeyPatch
) -> None:
    """``prove`` never makes such a proof, but a file may hold one."""
    prepared = marked_map()
    with working_precision(64):
        identity = system_hash(prepared)
    monkeypatch.setattr(verification, "_prepared", lambda *_, **__: prepared)
    size, symmetries = prepared.system.state_size, len(prepared.system.symmetries)
    numbers = {"bits": 64, "order": 4, "centre": ["0p0"] * size, "radii": ["1p-9"] * size, "steps": [["1p-9"]]}
    weight = np.eye(size - symmetries).tolist()
    found = SimpleNamespace(**numbers, weight=weight, rate=0.5, basin_size=None)
    forged = SimpleNamespace(found=found, system=identity, half=stabilised_gait.pattern.mirrored)
    forged.proved = SimpleNamespace(durations=[("0.19", "0.2")])
    with pytest.raises(InputError, match="the control law is not smooth after"):
        verification.verify(forged, stabilised_gait)  # type: ignore[arg-type]
    forged.proved = SimpleNamespace(durations=[])
    with pytest.raises(InputError, match="another number of states or domains"):
        verification.verify(forged, stabilised_gait)  # type: ignore[arg-type]


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


@lru_cache(maxsize=1)
def enclosed() -> tuple[HybridSystem, ReturnMap, list[arb], Enclosure]:
    """Half a cycle from a box about the fixed point."""
    system, found = closed_loop_fixed_point(gaits.stabilised())
    with working_precision(128):
        prepared = gait_map(gaits.stabilised(), system, 24, 1e-22)
        centre = [arb(float(value)) for value in found.state]
        return system, prepared, centre, prepared(centre, [arb(RADIUS)] * len(centre))


def rate_of(leg: Leg) -> Rate:
    return lambda clock, state: [value.mid() for value in leg.field.part(clock, state).rate]


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(20))
def test_random_starts_land_in_the_enclosures(seed: int) -> None:
    """Half a cycle from anywhere in the box: in 60 digits, by extrapolation; M z = b is solved at every point.

    The simulator's eliminated formulas will not do: they fold constants in floating point, and end 4e-17 off.
    """
    system, prepared, centre, found = enclosed()
    draws = np.random.default_rng(seed)
    with working_precision(BITS):
        offset = [arb(int(k)) * RADIUS / 2**20 for k in draws.integers(-(2**20), 2**20 + 1, len(centre))]
        state = [c + o for c, o in zip(centre, offset, strict=True)]
    for leg, arc in zip(prepared.legs, found.arcs, strict=True):
        clock, state = landed(leg, rate_of(leg), state, arc.duration.mid(), STEPS, COLUMNS)
        assert arc.duration.contains(clock)
    with working_precision(BITS):
        reached = (found.derivative * column(offset)).entries()
        for name, at, extra, whole, value in zip(
            system.state_names, found.centre, reached, found.image, state, strict=True
        ):
            assert whole.contains(value), name
            assert (at + extra).overlaps(value + arb(0, ERROR)), name
            assert float((at + extra).rad()) < 1e-2 * RADIUS, name
