"""Named numbers with units, from gaits and traces."""

from amble.metrics.comparison import Comparison, Reduction, compare
from amble.metrics.energy import TorqueMetrics, torque_metrics
from amble.metrics.motion import Motion

__all__ = ["Comparison", "Motion", "Reduction", "TorqueMetrics", "compare", "torque_metrics"]
