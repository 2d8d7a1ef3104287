"""What crosses floors, as library calls: from a specification to a report."""

from amble.workflow.library import (
    Library,
    LibraryEntry,
    Transitions,
    build_library,
    load_library,
    load_transitions,
    steer,
    transitions,
)
from amble.workflow.measure import measure, rewrite_report
from amble.workflow.reproduce import Run, reproduce
from amble.workflow.specified import synthesize_specification

__all__ = [
    "Library",
    "LibraryEntry",
    "Run",
    "Transitions",
    "build_library",
    "load_library",
    "load_transitions",
    "measure",
    "reproduce",
    "rewrite_report",
    "steer",
    "synthesize_specification",
    "transitions",
]
