"""A gait record with every field filled with random numbers: good for files, no motion that could be walked."""

from __future__ import annotations

import numpy as np

from amble.control.allocation import AllocationLaw, PseudoInverse
from amble.control.outputs import joint_outputs
from amble.gait import Gait, LagrangeMultipliers
from amble.hybrid.gaits import amble
from amble.robot import catalogue
from amble.types import frozen
from fuzz.gait_bases import SOLVED, drawn_domain, drawn_feedback, loose_limits

NODES = 7


def random_gait(seed: int = 0, law: AllocationLaw | None = None, stabilised: bool = True) -> Gait:
    """Fill a gait of the catalogue's astro."""
    random = np.random.default_rng(seed)
    pattern = amble(catalogue.astro())
    outputs = joint_outputs(pattern, order=4)
    return Gait(
        pattern=pattern,
        outputs=outputs,
        law=PseudoInverse() if law is None else law,
        speed=0.2,
        gains=(100.0, 20.0),
        limits=loose_limits(pattern),
        domains=tuple(drawn_domain(random, pattern, place, outputs, NODES) for place in range(len(pattern.solved))),
        solver=SOLVED,
        feedback=drawn_feedback(random, pattern, outputs) if stabilised else None,
        versions={"amble": "0.1.0", "casadi": "3.8.2"},
        multipliers=LagrangeMultipliers(frozen(random.normal(size=4)), frozen(random.normal(size=3))) if seed else None,
    )
