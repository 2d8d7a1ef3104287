"""Hybrid systems, and the legged ones built from stance tables."""

from amble.hybrid.pattern import GaitPattern, Stance, Switch, gait_pattern
from amble.hybrid.system import Domain, HybridSystem, Symmetry, Transition

__all__ = ["Domain", "GaitPattern", "HybridSystem", "Stance", "Switch", "Symmetry", "Transition", "gait_pattern"]
