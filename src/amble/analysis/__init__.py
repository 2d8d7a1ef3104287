"""Named numbers with units, from gaits and traces."""

from amble.analysis.bounds import ContactBounds
from amble.analysis.comparison import Comparison, LawMetrics, Reduction, compare
from amble.analysis.contact import ContactReport, contact_report, monitors
from amble.analysis.energy import TorqueMetrics, torque_metrics
from amble.analysis.laws import (
    LawChoice,
    actuators_for,
    compare_laws,
    every_law,
    is_papers,
    labelled,
    paper_laws,
    with_laws,
)
from amble.analysis.limit_use import AllocationLimits, LimitUse
from amble.analysis.motion import Motion
from amble.analysis.reallocation import Allocated, reallocate
from amble.analysis.reference import ReferenceMotion, reference_motion
from amble.analysis.reference_files import write_reference
from amble.analysis.samples import Samples, samples_of_gait, samples_of_trace
from amble.analysis.survival import survived_cycles

__all__ = [
    "Allocated",
    "AllocationLimits",
    "Comparison",
    "ContactBounds",
    "ContactReport",
    "LawChoice",
    "LawMetrics",
    "LimitUse",
    "Motion",
    "Reduction",
    "ReferenceMotion",
    "Samples",
    "TorqueMetrics",
    "actuators_for",
    "compare",
    "compare_laws",
    "contact_report",
    "every_law",
    "is_papers",
    "labelled",
    "monitors",
    "paper_laws",
    "reallocate",
    "reference_motion",
    "samples_of_gait",
    "samples_of_trace",
    "survived_cycles",
    "torque_metrics",
    "with_laws",
    "write_reference",
]
