"""Hybrid systems, and the legged ones built from stance tables."""

from amble.hybrid.contact import (
    ConstrainedDynamics,
    constrained_dynamics,
    impact,
    selection,
    stance_bias,
    stance_jacobian,
)
from amble.hybrid.pattern import GaitPattern, Stance, Switch, gait_pattern
from amble.hybrid.system import Domain, HybridSystem, Invariant, Symmetry, Transition

__all__ = [
    "ConstrainedDynamics",
    "Domain",
    "GaitPattern",
    "HybridSystem",
    "Invariant",
    "Stance",
    "Switch",
    "Symmetry",
    "Transition",
    "constrained_dynamics",
    "gait_pattern",
    "impact",
    "selection",
    "stance_bias",
    "stance_jacobian",
]
