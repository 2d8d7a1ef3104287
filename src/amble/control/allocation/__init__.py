"""Allocation laws, one a file."""

from amble.control.allocation.drop_actuator import DropActuator
from amble.control.allocation.internal_forces import internal_forces
from amble.control.allocation.law import AllocationLaw, Redundancy
from amble.control.allocation.pseudo_inverse import PseudoInverse
from amble.control.allocation.registry import law_from

__all__ = ["AllocationLaw", "DropActuator", "PseudoInverse", "Redundancy", "internal_forces", "law_from"]
