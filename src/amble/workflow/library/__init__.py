"""A library: gaits of one specification over axes such as speed and height, each certified, in one folder."""

from amble.workflow.library.between import Transitions, load_transitions, steer, transitions
from amble.workflow.library.build import build_library
from amble.workflow.library.files import Library, LibraryEntry, load_library

__all__ = [
    "Library",
    "LibraryEntry",
    "Transitions",
    "build_library",
    "load_library",
    "load_transitions",
    "steer",
    "transitions",
]
