"""Outputs, input-output linearisation, allocation laws, actuator models."""

from amble.control.allocation import (
    AllocationLaw,
    DropActuator,
    PseudoInverse,
    Redundancy,
    internal_forces,
    law_from,
)
from amble.control.outputs import DomainOutputs, Outputs, joint_outputs

__all__ = [
    "AllocationLaw",
    "DomainOutputs",
    "DropActuator",
    "Outputs",
    "PseudoInverse",
    "Redundancy",
    "internal_forces",
    "joint_outputs",
    "law_from",
]
