"""What crosses floors, as library calls: from a specification to a report."""

from amble.workflow.library import Library, LibraryEntry, build_library, load_library
from amble.workflow.measure import measure, rewrite_report
from amble.workflow.reproduce import Run, reproduce
from amble.workflow.specified import synthesize_specification

__all__ = [
    "Library",
    "LibraryEntry",
    "Run",
    "build_library",
    "load_library",
    "measure",
    "reproduce",
    "rewrite_report",
    "synthesize_specification",
]
