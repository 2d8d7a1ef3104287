"""Named numbers with units, from gaits and traces."""

from amble.analysis.bounds import ContactBounds
from amble.analysis.comparison import Comparison, Reduction, compare
from amble.analysis.contact import ContactReport, Worst, contact_report
from amble.analysis.energy import TorqueMetrics, torque_metrics
from amble.analysis.motion import Motion
from amble.analysis.reallocation import Allocated, reallocate
from amble.analysis.samples import Samples, samples_of_gait, samples_of_trace

__all__ = [
    "Allocated",
    "Comparison",
    "ContactBounds",
    "ContactReport",
    "Motion",
    "Reduction",
    "Samples",
    "TorqueMetrics",
    "Worst",
    "compare",
    "contact_report",
    "reallocate",
    "samples_of_gait",
    "samples_of_trace",
    "torque_metrics",
]
