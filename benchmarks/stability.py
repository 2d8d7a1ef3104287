"""The return map's derivative, stabilisation of the optimised gait below a spectral radius of one, its certificate."""

from __future__ import annotations

import time
from dataclasses import replace

from amble.gait.closed_loop import closed_loop, start_state
from amble.stability.certification import certify
from amble.stability.monodromy import monodromy, prepare_variational
from amble.stability.stabilize import stabilization
from benchmarks.figures import Figure, show, timed
from benchmarks.gaits import walking_gait

TOLERANCE = 1e-10


def measure() -> list[Figure]:
    """Measure both."""
    gait = walking_gait()
    system, start = closed_loop(gait, half=True), start_state(gait)
    monodromy(system, start, TOLERANCE)  # fills the compile cache
    prepared = prepare_variational(system)
    whole, _ = timed(lambda: monodromy(system, start, TOLERANCE))
    once, _ = timed(lambda: prepared(start, TOLERANCE), 7)
    bare = replace(gait, feedback=None)
    seconds, found = timed(lambda: stabilization(bare), 1, time.process_time)
    certified, _ = timed(lambda: certify(gait), 1, time.process_time)
    steps = len(found.steps) - 1
    note = f"radius of a cycle {found.initial:.3g} -> {found.radius:.3g}, bound {found.bound:.3g}, in {steps} steps"
    return [
        Figure("monodromy of half a cycle, with preparing", whole, "s", runs=3, note="variational equations at 1e-10"),
        Figure("monodromy of half a cycle, prepared", once, "s", runs=7),
        Figure("stabilisation, processor time", seconds, "s", note=note),
        Figure("certificate, processor time", certified, "s"),
        Figure("spectral radius after stabilisation", found.radius, "", most=1.0),
    ]


def main() -> None:
    """Print what is measured."""
    show(measure())


if __name__ == "__main__":
    main()
