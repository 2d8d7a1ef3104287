"""The gait record, its file, and its check."""

from amble.gait.limits import Limits
from amble.gait.record import DomainTrajectory, Feedback, Gait, LagrangeMultipliers, SolverReport

__all__ = ["DomainTrajectory", "Feedback", "Gait", "LagrangeMultipliers", "Limits", "SolverReport"]
