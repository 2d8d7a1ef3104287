"""Named numbers with units, from gaits and traces."""

from amble.metrics.bounds import ContactBounds
from amble.metrics.comparison import Comparison, Reduction, compare
from amble.metrics.contact import ContactReport, Worst, contact_report
from amble.metrics.energy import TorqueMetrics, torque_metrics
from amble.metrics.motion import Motion
from amble.metrics.reallocation import Allocated, reallocate
from amble.metrics.samples import Samples, samples_of_gait, samples_of_trace

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
