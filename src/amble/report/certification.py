"""The certificate of a gait: its closed loop's own orbit, stable and sound in every contact."""

from __future__ import annotations

from dataclasses import replace

from amble.errors import Row
from amble.gait import Gait
from amble.gait.closed_loop import closed_loop
from amble.hybrid import HybridSystem
from amble.metrics import ContactBounds, contact_report
from amble.simulation import Trace, simulate
from amble.stability import Certificate, Spectrum, certify, multipliers, section_distances
from amble.stability.leading_mode import LeadingMode, leading_mode
from amble.stability.own_orbit import own_fixed_point
from amble.types import Vector

TOLERANCE = 1e-10
"""Of the integrator, for the cycle on which contacts are looked at."""


def certify_gait(gait: Gait) -> Certificate:
    """Certify the full cycle of a gait's closed loop; everything is computed again from the gait.

    Raises:
        CertificateError: the radius with its error bar is not below 1, or a contact is violated on the orbit.
        FallError: the motion does not come back.
        NotSolvedError: the closed loop has no fixed point near the gait.
    """
    system = closed_loop(gait)
    state = own_fixed_point(gait)[1].state
    return certify(system, state, contact_conditions(gait, system, state))


def initial_spectrum(gait: Gait) -> Spectrum:
    """Return the multipliers of the full cycle under the outputs of the gait problem, feedback left out."""
    bare = replace(gait, feedback=None)
    _, found = own_fixed_point(bare)
    return multipliers(closed_loop(bare), found.state)


def distances(gait: Gait, trace: Trace, certificate: Certificate) -> Vector:
    """Return the distance to the certified fixed point at the entry of every simulated cycle, (cycles + 1,)."""
    return section_distances(closed_loop(gait), trace.section, certificate.state)


def contact_conditions(gait: Gait, system: HybridSystem, state: Vector) -> tuple[Row, ...]:
    """Return what must hold in every contact of the cycle from a state: normal forces, friction, heights, drift, rank.

    Limits of joints are not conditions of the model's validity; the report shows them.
    """
    bounds = replace(ContactBounds.of_limits(gait.limits), torques={}, speeds={})
    trace = simulate(system, state, 1, TOLERANCE)
    return tuple(worst.row for worst in contact_report(trace, gait.pattern, bounds).rows)


def measured_mode(gait: Gait, certificate: Certificate) -> LeadingMode:
    """Measure the decay of the leading mode in simulation of the full cycle."""
    return leading_mode(closed_loop(gait), certificate.state, certificate.spectrum)
