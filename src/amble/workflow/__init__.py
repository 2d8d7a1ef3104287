"""What crosses floors, as library calls: from a specification to a report."""

from amble.workflow.measure import measure, rewrite_report
from amble.workflow.reproduce import Run, reproduce
from amble.workflow.specified import synthesize_specification

__all__ = ["Run", "measure", "reproduce", "rewrite_report", "synthesize_specification"]
