"""Phase, outputs, input-output linearisation, allocation laws, actuator models."""

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
from amble.control.phase import PHASES, Phase, PhaseNumber, TimePhase

__all__ = [
    "LAWS",
    "PHASES",
    "AllocationLaw",
    "BoundedMinimumNorm",
    "ContactLimits",
    "DomainOutputs",
    "DropActuator",
    "MinimumPeak",
    "MinimumPower",
    "Outputs",
    "Phase",
    "PhaseNumber",
    "PseudoInverse",
    "Redundancy",
    "TimePhase",
    "WeightedMinimumNorm",
    "joint_outputs",
    "law_from",
    "margins",
]
