"""A motion at even nodes, which splines over time can be put through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from amble.gait import DomainTrajectory
from amble.numerics.collocation import HERMITE_SIMPSON, STAGES, through_nodes
from amble.types import frozen
from amble.verification.interpolation import interpolated

SPACINGS = 8
"""Even spacings an interval: its end spacings are much shorter than the middle ones, and the cubics of a spline are of
lower order than its polynomials."""


def evenly_sampled(domain: DomainTrajectory) -> DomainTrajectory:
    """Return a motion at even clocks, on the polynomials of its intervals; itself where its nodes are even already."""
    if STAGES[domain.scheme] == STAGES[HERMITE_SIMPSON]:
        return domain
    times = np.linspace(0.0, domain.duration, SPACINGS * domain.intervals + 1)
    positions, velocities = interpolated(domain, times)
    accelerations, torques, forces = (
        frozen(through_nodes(domain.scheme, values, times / domain.duration))
        for values in (domain.accelerations, domain.torques, domain.forces)
    )
    return replace(
        domain,
        times=frozen(times),
        positions=frozen(positions),
        velocities=frozen(velocities),
        accelerations=accelerations,
        torques=torques,
        forces=forces,
        scheme=HERMITE_SIMPSON,
    )
