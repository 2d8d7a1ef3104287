"""The stabilised amble of tests/data proved once, and its proof's enclosures computed anew once, for slow tests."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from pathlib import Path

from flint import arb

from amble.gait import Gait
from amble.gait.files import load_gait
from amble.gait.impedance import Impedance
from amble.proof import Proof, prove_gait
from amble.proof.arithmetic import working_precision
from amble.proof.gait_map import gait_map
from amble.proof.return_map import ReturnMap
from amble.proof.verification import Recomputed, recomputed
from amble.stability.closed_loop_orbit import closed_loop_fixed_point

DATA = Path(__file__).parents[1] / "data"


@lru_cache(maxsize=1)
def stabilised() -> Gait:
    return load_gait(DATA / "stabilised-amble.json")


@lru_cache(maxsize=1)
def sprung() -> Gait:
    """The same orbit under joint impedance with its default gains."""
    return replace(stabilised(), control=Impedance())


@lru_cache(maxsize=1)
def loop() -> tuple[ReturnMap, list[arb]]:
    """The return map of half a cycle, prepared for enclosures, and its fixed point by simulation."""
    system, found = closed_loop_fixed_point(stabilised())
    with working_precision(128):
        return gait_map(stabilised(), system, 24, 1e-25), [arb(float(value)) for value in found.state]


@lru_cache(maxsize=1)
def proof() -> Proof:
    return prove_gait(stabilised())


@lru_cache(maxsize=1)
def again() -> Recomputed:
    return recomputed(proof(), stabilised())
