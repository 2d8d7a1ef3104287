"""A simulated motion held against the limits of its gait."""

from __future__ import annotations

from amble.analysis.bounds import ContactBounds
from amble.analysis.contact import ContactReport, contact_report
from amble.gait import Gait
from amble.simulation import Trace


def monitors(gait: Gait, trace: Trace) -> ContactReport:
    """Hold a simulated motion against the limits of its gait."""
    return contact_report(trace, gait.pattern, ContactBounds.of_gait(gait))
