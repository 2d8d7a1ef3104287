"""Outputs, input-output linearisation, allocation laws, actuator models."""

from amble.control.allocation import AllocationLaw, Redundancy
from amble.control.outputs import DomainOutputs, Outputs

__all__ = ["AllocationLaw", "DomainOutputs", "Outputs", "Redundancy"]
