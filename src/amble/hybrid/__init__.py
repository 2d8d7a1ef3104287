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
from amble.hybrid.system import Domain, HybridSystem, Symmetry, Transition

__all__ = [
    "ConstrainedDynamics",
    "Domain",
    "GaitPattern",
    "HybridSystem",
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
