"""The gait that benchmarks walk; nothing that the bench extra holds is imported for it."""

from __future__ import annotations

from pathlib import Path

from amble.gait import Gait
from amble.gait.files import load_gait

ROOT = Path(__file__).resolve().parents[1]


def walking_gait() -> Gait:
    """Return the amble that the tests walk."""
    return load_gait(ROOT / "tests" / "data" / "stabilised-amble.json")
