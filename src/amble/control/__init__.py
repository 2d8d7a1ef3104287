"""Outputs, input-output linearisation, allocation laws, actuator models."""

from amble.control.allocation import (
    LAWS,
    AllocationLaw,
    BoundedMinimumNorm,
    ContactLimits,
    DropActuator,
    MinimumPeak,
    MinimumPower,
    PseudoInverse,
    Redundancy,
    WeightedMinimumNorm,
    law_from,
    margins,
)
from amble.control.outputs import DomainOutputs, Outputs, joint_outputs

__all__ = [
    "LAWS",
    "AllocationLaw",
    "BoundedMinimumNorm",
    "ContactLimits",
    "DomainOutputs",
    "DropActuator",
    "MinimumPeak",
    "MinimumPower",
    "Outputs",
    "PseudoInverse",
    "Redundancy",
    "WeightedMinimumNorm",
    "joint_outputs",
    "law_from",
    "margins",
]
