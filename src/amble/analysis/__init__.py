"""Named numbers with units, from gaits and traces."""

from amble.analysis.bounds import ContactBounds
from amble.analysis.comparison import Comparison, Reduction, compare
from amble.analysis.contact import ContactReport, Worst, contact_report
from amble.analysis.energy import TorqueMetrics, torque_metrics
from amble.analysis.laws import LawChoice, compare_allocations, compare_laws, every_law, paper_laws
from amble.analysis.monitors import monitors
from amble.analysis.motion import Motion
from amble.analysis.reallocation import Allocated, reallocate
from amble.analysis.samples import Samples, samples_of_gait, samples_of_trace

__all__ = [
    "Allocated",
    "Comparison",
    "ContactBounds",
    "ContactReport",
    "LawChoice",
    "Motion",
    "Reduction",
    "Samples",
    "TorqueMetrics",
    "Worst",
    "compare",
    "compare_allocations",
    "compare_laws",
    "contact_report",
    "every_law",
    "monitors",
    "paper_laws",
    "reallocate",
    "samples_of_gait",
    "samples_of_trace",
    "torque_metrics",
]
