"""Outputs, input-output linearisation, allocation laws, actuator models."""

from amble.control.allocation import (
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
